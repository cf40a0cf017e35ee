"""Scenes that a test makes for itself."""

import array
import json
import math
import struct


def glb(document, binary):
    """A GLB of this document and these bytes."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) + struct.pack("<II", len(text), 0x4E4F534A)
            + text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def glb_parts(file):
    """The document and the bytes of a GLB that glb() made."""
    length = struct.unpack_from("<I", file, 12)[0]
    return json.loads(file[20:20 + length]), file[28 + length:]


def triangle_glb(nodes, places=None):
    """One mesh, 0, of the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0), and these nodes, all of them roots; with `places`, an array
    of coordinates, the first node has the mesh at each of them."""
    corners = array.array("f", (0, 0, 0, 1, 0, 0, 0, 1, 0)).tobytes()
    moved = places.tobytes() if places else b""
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                "buffers": [{"byteLength": len(corners + moved)}], "bufferViews": [{"buffer": 0, "byteLength": len(corners)}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 0]}]}
    if places:
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(corners), "byteLength": len(moved)})
        document["accessors"].append({"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": len(places) // 3})
        document["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
        nodes[0] = {**nodes[0], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}
    return glb(document, corners + moved)


def tiles(side, count, own=False):
    """A GLB of a hilly tile of 2 * side * side triangles, placed so often; `own`: each place has a mesh with positions of its own."""
    def positions(number):
        return b"".join(struct.pack("<3f", x * 10 / side, math.sin((x + number) / 9) * math.cos(y / 7), y * 10 / side)
                        for y in range(side + 1) for x in range(side + 1))
    row, meshes = side + 1, count if own else 1
    indices = b"".join(struct.pack("<6I", a, a + row, a + 1, a + 1, a + row, a + row + 1)
                       for y in range(side) for a in range(y * row, y * row + side))
    data, size = indices + b"".join(positions(i) for i in range(meshes)), 12 * row * row
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(count))}],
        "nodes": [{"mesh": i if own else 0, "name": f"tile {i}", "translation": [10 * (i % 32), 0, 10 * (i // 32)]} for i in range(count)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1 + i}, "indices": 0}]} for i in range(meshes)],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(indices)}, {"buffer": 0, "byteOffset": len(indices), "byteLength": meshes * size}],
        "accessors": [{"bufferView": 0, "componentType": 5125, "count": 6 * side * side, "type": "SCALAR"}]
                     + [{"bufferView": 1, "byteOffset": i * size, "componentType": 5126, "count": row * row, "type": "VEC3", "min": [0, -1, 0],
                         "max": [10, 1, 10]} for i in range(meshes)]}
    return glb(document, data)
