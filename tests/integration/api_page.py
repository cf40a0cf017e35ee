"""docs/reference/api.md: one curl line for each question and the answer that a server gives to it.

Usage: api_page.py BINARY [--write]; api_page_test.py holds the page against the server.
"""

import json
import re
import shlex
import subprocess
import sys

DOWN = {"origin": [0, 100, 0], "direction": [0, -1, 0]}
SQUARE = {"origin": [3, 200, 5], "direction": [0, -1, 0]}
MISS = {"origin": [3, 200, 5], "direction": [0, 1, 0]}
TOWN, SIX, PAINTED = "/v1/scenes/town/", "/v1/scenes/six/", "/v1/scenes/painted/"
# As the page says.
SERVED = ["--skip", "none", "--preload", "town=demo:town", "--preload", "six=demo:six", "--preload", "painted=demo:painted"]

# Title, path, body or None for GET, and the method where it is another one than these say.
QUESTIONS = [
    ("The first triangle that each ray meets", TOWN + "rays:closest", {"rays": [SQUARE, MISS]}),
    ("Columns, with chosen fields", TOWN + "rays:closest",
     {"origins": [3, 200, 5, 3, 200, 5], "directions": [0, -1, 0, 0, 1, 0], "fields": ["t", "node_path", "front", "on_edge"]}),
    ("What the file says of the place", PAINTED + "rays:closest",
     {"rays": [{"origin": [0.5, -0.5, 5], "direction": [0, 0, -1]}], "fields": ["t", "normal", "shading_normal", "uv", "colour"]}),
    ("In scene units", TOWN + "rays:closest",
     {"rays": [{"origin": [3, 200, 5], "direction": [0, -4, 0], "tmax": 199.75}], "normalize": True, "fields": ["t", "distance", "node"]}),
    ("Whether each ray meets anything", TOWN + "rays:any", {"rays": [SQUARE, MISS]}),
    ("Every hit", TOWN + "rays:all", {"rays": [DOWN], "max_hits": 5, "fields": ["t", "node", "triangle"]}),
    ("Every surface once", TOWN + "rays:all", {"rays": [{**DOWN, "tmax": 99}], "crossings": "once", "fields": ["t", "node"]}),
    ("How many", TOWN + "rays:count", {"rays": [DOWN, SQUARE, MISS]}),
    ("Without what stands in the way", TOWN + "rays:closest",
     {"rays": [DOWN], "exclude": {"names": ["spire"]}, "cull": "back", "fields": ["t", "node", "material"]}),
    ("With bad rays marked", TOWN + "rays:any",
     {"rays": [SQUARE, {"origin": [0, 0, 0], "direction": [0, 0, 0]}], "on_invalid": "mark"}),
    ("What a scanner sees", TOWN + "rays:closest",
     {"generator": {"kind": "lidar", "position": [3, 2, 5], "elevations": [-5, 5], "azimuths": 4, "range": [0, 100]},
      "fields": ["distance", "node_id"]}),
    ("And behind it, three returns of a ray", SIX + "rays:closest",
     {"generator": {"kind": "lidar", "position": [-10, 1, 0], "forward": [1, 0, 0], "elevations": [0], "azimuths": 1, "returns": 3},
      "fields": ["t", "node", "triangle"]}),
    ("The rays of a camera", "/v1/rays:generate",
     {"generator": {"kind": "orthographic", "position": [0, 50, 0], "forward": [0, -1, 0], "up": [0, 0, -1], "extent_y": 4, "width": 2,
                    "height": 2, "range": [0, 60]}}),
    ("Which points see which", TOWN + "visibility", {"from": [[-40, 12, 1], [40, 12, 1]], "to": [[-20, 12, 1], [20, 12, 1]]}),
    ("And what stands between", TOWN + "visibility",
     {"from": [[-40, 12, 1]], "to": [[40, 12, 1]], "pairing": "each", "first_blocker": True, "fields": ["t", "distance", "node"]}),
    ("Which points lie inside", TOWN + "points:inside",
     {"points": [[0, 10, 0.5], [0.5, 18.25, 1], [-3, 12, 1], [0, 33, 0]], "method": "winding", "include": {"names": ["clock tower", "spire"]}}),
    ("The nearest point of the scene", TOWN + "points:closest",
     {"points": [[-7, 9, 0], [0, 400, 0]], "max_distance": 100, "fields": ["distance", "position", "node", "on_edge"]}),
    ("The nearest triangles", TOWN + "points:nearest",
     {"points": [[0, 34, 0]], "count": 3, "fields": ["distance", "instance", "triangle", "node"]}),
    ("How far inside or outside", TOWN + "points:distance",
     {"points": [[0, 10, 0.5], [-7, 9, 0]], "include": {"names": ["clock tower", "spire"]}}),
    ("Where inside is not defined", SIX + "points:distance", {"points": [[0, 50, 0]], "method": "winding"}),
    ("How much of the sky a point sees", TOWN + "points:sky", {"points": [[3, 0.5, 5], [0, 400, 0]], "count": 64}),
    ("What a box touches", TOWN + "boxes:list",
     {"boxes": [{"min": [-4, 20, -4], "max": [4, 33, 4]}, {"min": [None, 97, None], "max": [None, None, None]}], "of": "nodes"}),
    ("How many triangles", TOWN + "boxes:count",
     {"boxes": [{"center": [0, 28, 0], "half": [5, 5, 5], "rotation": [0, 0.6, 0, 0.8]}]}),
    ("A list in pieces", TOWN + "boxes:list", {"boxes": [{"min": [-4, 20, -4], "max": [4, 33, 4]}], "of": "nodes", "limit": 1}),
    ("What a capsule holds", TOWN + "boxes:count",
     {"boxes": [{"from": [0, 24, 0], "to": [0, 32, 0], "radius": 6}], "mode": "contained", "of": "nodes"}),
    ("What a pyramid of planes touches", TOWN + "boxes:list",
     {"boxes": [{"planes": [[0, 1, 0, 33], [1, -1, 0, -31], [-1, -1, 0, -31], [0, -1, 1, -31], [0, -1, -1, -31]]}], "of": "nodes"}),
    ("What the hull of points touches", TOWN + "boxes:list",
     {"boxes": [{"hull": [[0, 33, 0], [9, 27, 0], [-9, 27, 0], [0, 27, 9], [0, 27, -9]]}], "of": "nodes"}),
    ("How deep a ball is in what it touches", TOWN + "boxes:list",
     {"boxes": [{"center": [-7, 12, 1], "radius": 5}], "contacts": True, "limit": 1}),
    ("What a camera sees", TOWN + "boxes:list",
     {"boxes": [{"view": {"kind": "pinhole", "position": [0, 28, 40], "look_at": [0, 28, 0], "fov_y": 10, "width": 4, "height": 3, "range": [1, 80]}}],
      "of": "nodes"}),
    ("What lies between eight corners", TOWN + "boxes:count",
     {"boxes": [{"corners": [[-4, 20, -4], [4, 20, -4], [4, 20, 4], [-4, 20, 4], [-1, 31, -1], [1, 31, -1], [1, 31, 1], [-1, 31, 1]]}]}),
    ("How many in a sphere", TOWN + "boxes:count", {"boxes": [{"center": [3, 44, 4], "radius": 13}]}),
    ("Whether any", TOWN + "boxes:any", {"boxes": [{"min": [-1, 500, -1], "max": [1, 501, 1]}]}),
    ("What a moving sphere meets", TOWN + "sweeps:closest",
     {"sweeps": [{"origin": [-40, 12, 1], "direction": [1, 0, 0], "radius": 5}], "fields": ["t", "position", "node"]}),
    ("What a falling box meets", TOWN + "sweeps:closest",
     {"sweeps": [{"origin": [0, 50, 0], "direction": [0, -1, 0], "half": [1, 2, 1]}], "fields": ["t", "position", "node", "triangle"]}),
    ("How much a point is inside of open meshes", SIX + "points:inside", {"points": [[-5, 1, 0], [0, 50, 0]], "method": "solid_angle"}),
    ("Where a moving capsule and a turned box touch", TOWN + "sweeps:closest",
     {"sweeps": [{"from": [-40, 14, 1], "to": [-36, 10, 1], "direction": [1, 0, 0], "radius": 2},
                 {"origin": [-40, 12, 1], "direction": [1, 0, 0], "half": [1, 1, 1], "axes": [[1, 1, 0], [-1, 1, 0], [0, 0, 1]]}],
      "fields": ["t", "position", "normal"]}),
    ("Whether there is room to pass", TOWN + "sweeps:any",
     {"sweeps": [{"origin": [0, 40, 90], "direction": [0, 0, -1], "tmax": 80, "half": [1, 1, 1]}]}),
    ("How far two things are from each other", TOWN + "clearance", {"a": {"names": ["spire"]}, "b": {"names": ["house*", "street*"]}}),
    ("What stands within a distance", SIX + "clearance",
     {"a": {"names": ["left"]}, "b": {"names": ["right"]}, "max_distance": 4, "pairs": "triangles", "limit": 1}),
    ("Rays against boxes, without a scene", "/v1/rays-boxes",
     {"rays": [{"origin": [-10, 3, 0], "direction": [1, 0, 0]}], "boxes": [{"min": [-2, -3, -4], "max": [4, 3, 2]}]}),
    ("The nodes of a scene", SIX + "nodes", None),
    ("The nodes with a name, and their paths", SIX + "nodes?name=r*t&with=path,materials", None),
    ("Exact corners", SIX + "triangles?ids=0.0.0,1.0.2", None),
    ("What a ray came past", SIX + "rays:closest", {"rays": [{"origin": [3, 10, 0], "direction": [0, -1, 0]}], "explain": True, "fields": ["t", "node"]}),
    ("Exact brute force", SIX + "selfcheck?rays=100", None),
    ("To move a node", SIX + "nodes/2", {"translation": [0, 3, 0]}, "PATCH"),
    ("And where it is now", SIX + "rays:closest", {"rays": [{"origin": [3, 10, 0], "direction": [0, -1, 0]}], "fields": ["t", "node"]}),
    ("To hide it", SIX + "nodes/2", {"translation": [0, 0, 0], "hidden": True}, "PATCH"),
    ("To show it again", SIX + "nodes/2", {"hidden": False}, "PATCH"),
    ("To add a node with the mesh of another one", SIX + "nodes/100", {"copy_of": 2, "parent": 0, "name": "upper", "translation": [0, 6, 0]}, "PATCH"),
    ("And where it is", SIX + "rays:closest", {"rays": [{"origin": [3, 10, 0], "direction": [0, -1, 0]}], "fields": ["t", "node", "node_id"]}),
    ("To give it other vertices, for it alone", SIX + "nodes/100", {"positions": 3 * [[-1, 0, -1], [1, 0, -1], [0, 0, 1]]}, "PATCH"),
    ("To remove it", SIX + "nodes/100", None, "DELETE"),
    ("A fault", TOWN + "rays:any", {"rays": [{"origin": [0, 0], "direction": [1, 0, 0]}]}),
]

HEAD = """# Questions and answers

Each line was sent to a server, and the text below it is the answer. A test sends them again. Revisions are shown as 2 (in
cursors as they were), and ids of requests are left out. The scenes are the three demo scenes, with every tree built before:
`sightline serve --skip none --preload town=demo:town --preload six=demo:six --preload painted=demo:painted`. Words are explained
in [fields.md](fields.md), every key in [openapi.json](../../proto/openapi.json).
"""


def ask(url, path, body, method=None):
    options = ["-X", method, "-H", "Content-Type: application/json"] if method else []
    if body is not None:
        options += ["-d", json.dumps(body, separators=(",", ":"))]
    command = ["curl", "-s", url + path, *options]
    shown = shlex.join(["curl", "-s", "http://127.0.0.1:8080" + path, *options])
    answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout.strip()
    if '"request_id"' in answer:
        answer = answer[:answer.index(',"request_id"')] + "}"
    # A cursor begins with the revision of the scene: which of two was loaded first is left to chance.
    answer = re.sub('"next":"[0-9a-f]{16}', '"next":"' + 15 * "0" + "1", answer)
    answer = re.sub('"revision":[0-9]+', '"revision":2', answer)
    return shown, answer


def page(url):
    parts = [HEAD]
    for title, path, body, *method in QUESTIONS:
        shown, answer = ask(url, path, body, *method)
        parts.append(f"## {title}\n\n    {shown}\n\n    {answer}\n")
    return "\n".join(parts)


if __name__ == "__main__":
    from sightline_server import SOURCE, Server

    with Server(*SERVED) as server:
        if "--write" in sys.argv:
            (SOURCE / "docs/reference/api.md").write_text(page(server.url), encoding="utf-8")
        else:
            print(page(server.url))
