"""Cameras by intrinsics, matrices, crops and lists of pixels; scanners with sectors, firing tables, beams, noise and dropout.
Expected values come from the formulas of docs/reference/generators.md, written again here."""

import json
import math

import case_report
from binary_test import unpack
from images_test import read_floats, read_png
from two_scenes import TwoScenes

VIEW = {"kind": "pinhole", "position": [90, 60, 120], "look_at": [0, 10, 0], "width": 40, "height": 23}
SCAN = {"kind": "lidar", "position": [60, 12, 70], "elevations": [-20, -5, 0, 9], "azimuths": 90, "range": [1, 120]}
MASK = 2**64 - 1


def scramble(x):
    """splitmix64, by its paper."""
    x = (x + 0x9E3779B97F4A7C15) & MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    return x ^ (x >> 31)


def stream_of(seed, stream):
    """Numbers of [0, 1) of a stream of a seed."""
    state = scramble(seed) ^ (stream * 0x9E3779B97F4A7C15) & MASK
    while True:
        yield (scramble(state) >> 11) * 2.0**-53
        state = (state + 0x9E3779B97F4A7C15) & MASK


def node_colour(node):
    """Red, green and blue of a node, by the text of docs/guides/images.md."""
    hue = ((node * 0x9E3779B9) % 2**32 * 6) >> 24
    rising, falling = hue & 255, 255 - (hue & 255)
    parts = [(255, rising, 0), (falling, 255, 0), (0, 255, rising), (0, falling, 255), (rising, 0, 255), (255, 0, falling)][hue >> 8]
    return [part * (256 - 56 * (node % 3)) >> 8 for part in parts]


class Sensors(TwoScenes):
    def make(self, generator):
        """(origin, direction) of each ray."""
        answer = self.server.ask("/v1/rays:generate", "-H", "Content-Type: application/json", body=json.dumps({"generator": generator}))
        self.assertEqual(answer.status, 200, answer.body)
        rays = answer.json()
        return [(rays["origins"][i:i + 3], rays["directions"][i:i + 3]) for i in range(0, len(rays["origins"]), 3)]

    def closest(self, body, *arguments, scene="town"):
        answer = self.server.query(scene, "closest", body, *arguments)
        self.assertEqual(answer.status, 200, answer.body[:500])
        return answer

    def test_pixels_and_crops_have_the_rays_of_the_whole_picture(self):
        cameras = [VIEW, {**VIEW, "kind": "equirectangular"}, {**VIEW, "kind": "orthographic", "extent_y": 70}]
        for camera in cameras:
            with self.subTest(kind=camera["kind"]):
                whole = self.make(camera)
                pixels = [[0, 0], [39, 22], [7, 3], [7, 3], [39, 0]]
                self.assertEqual(self.make({**camera, "pixels": pixels}), [whole[40 * y + x] for x, y in pixels])
                self.assertEqual(self.make({**camera, "crop": [5, 20, 3, 2]}), [whole[40 * y + x] for y in (20, 21) for x in (5, 6, 7)])
                self.assertEqual(self.make({**camera, "crop": [0, 0, 40, 23]}), whole)
                self.assertEqual(self.make({**camera, "pixels": []}), [])

    def test_a_picture_of_a_crop_is_a_part_of_the_picture(self):
        for image in ("depth", "node", "normal"):
            _, _, rows = read_floats(self.closest({"generator": VIEW, "image": image}, "-H", "Accept: image/x-portable-floatmap").body)
            crop = {**VIEW, "crop": [11, 4, 19, 17]}
            width, height, part = read_floats(self.closest({"generator": crop, "image": image}, "-H", "Accept: image/x-portable-floatmap").body)
            each = len(rows[0]) // 40
            self.assertEqual((width, height, part), (19, 17, [row[11 * each:30 * each] for row in rows[4:21]]))

    def test_picking_at_a_pixel(self):
        answer = self.closest({"generator": {**VIEW, "pixels": [[20, 12]]}, "fields": ["t", "node_id", "material", "uv"]}).json()
        whole = self.closest({"generator": VIEW, "fields": ["t", "node_id"]}).json()
        self.assertEqual((answer["t"], answer["node_id"]), ([whole["t"][12 * 40 + 20]], [whole["node_id"][12 * 40 + 20]]))

    def test_fields_of_view_and_intrinsics(self):
        for angle in (1, 35.5, 90, 179):
            tangent = math.tan(math.radians(angle / 2))
            for i, (_, d) in enumerate(self.make({"kind": "pinhole", "fov_x": angle, "width": 6, "height": 4})):
                x, y = 2 * (i % 6 + 0.5) / 6 - 1, 1 - 2 * (i // 6 + 0.5) / 4
                for got, exact in zip(d, (x * tangent, y * tangent * 4 / 6, -1)):
                    self.assertAlmostEqual(got, exact, delta=1e-12 * max(1, tangent))
        lens = [525.5, 519.25, 2.75, 1.5]
        for i, (_, d) in enumerate(self.make({"kind": "pinhole", "intrinsics": lens, "width": 6, "height": 4})):
            x, y = (i % 6 + 0.5 - lens[2]) / lens[0], (i // 6 + 0.5 - lens[3]) / lens[1]
            self.assertEqual(d, [x, -y, -1])
        # The lens of a field of view: half the height divided by its tangent.
        focal = 23 / 2 / math.tan(math.radians(30))
        same = {**VIEW, "intrinsics": [focal, focal, 20, 11.5]}
        for (_, a), (_, b) in zip(self.make(VIEW), self.make(same)):
            for got, exact in zip(b, a):
                self.assertAlmostEqual(got, exact, delta=1e-14)

    def test_an_extrinsic_matrix_maps_the_world_to_the_camera(self):
        # The camera looks along -x and stands at (7, 2, 3); right is -z, down is -y.
        rows = [[0, 0, -1], [0, -1, 0], [-1, 0, 0]]
        at = [7, 2, 3]
        matrix = [[*row, -sum(a * b for a, b in zip(row, at))] for row in rows] + [[0, 0, 0, 1]]
        for camera in ({"kind": "pinhole", "intrinsics": [4, 4, 2, 2], "width": 4, "height": 4}, {"kind": "equirectangular", "width": 6, "height": 4}):
            by_matrix = self.make({**camera, "extrinsic": matrix})
            by_pose = self.make({**camera, "position": at, "forward": [-1, 0, 0], "up": [0, 1, 0]})
            self.assertEqual(by_matrix, by_pose)
        for i, (origin, d) in enumerate(self.make({"kind": "pinhole", "intrinsics": [4, 4, 2, 2], "width": 4, "height": 4, "extrinsic": matrix})):
            self.assertEqual(origin, at)
            seen = [sum(a * b for a, b in zip(row, d)) for row in rows]
            self.assertEqual(seen, [(i % 4 + 0.5 - 2) / 4, (i // 4 + 0.5 - 2) / 4, 1])

    def test_sectors_and_firing_tables(self):
        whole = self.make({"kind": "lidar", "elevations": [3], "azimuths": 360})
        part = self.make({"kind": "lidar", "elevations": [3], "azimuths": 40, "sector": [10, 50]})
        self.assertEqual(part, whole[10:50])
        left = self.make({"kind": "lidar", "elevations": [3], "azimuths": 20, "sector": [-20, 0]})
        self.assertEqual(left, whole[340:])
        table = [[0, -15], [1.5, 1], [-0.75, 15]]
        fired = self.make({"kind": "lidar", "firings": table, "azimuths": 8, "sector": [0, 90]})
        self.assertEqual(len(fired), 24)
        for i, (_, d) in enumerate(fired):
            azimuth, elevation = (math.radians(x) for x in (90 * (i // 3) / 8 + table[i % 3][0], table[i % 3][1]))
            expected = [-math.cos(elevation) * math.sin(azimuth), math.sin(elevation), -math.cos(elevation) * math.cos(azimuth)]
            for got, exact in zip(d, expected):
                self.assertAlmostEqual(got, exact, delta=4e-16)

    def test_beams_fill_a_cone(self):
        axes = self.make({"kind": "lidar", "elevations": [-20, 40], "azimuths": 5})
        samples = 200
        rays = self.make({"kind": "lidar", "elevations": [-20, 40], "azimuths": 5, "divergence": 2, "samples": samples})
        self.assertEqual(len(rays), len(axes) * samples)
        for beam, (origin, axis) in enumerate(axes):
            cone = rays[beam * samples:(beam + 1) * samples]
            self.assertEqual(cone[0], (origin, axis))
            angles, quadrants = [], [0] * 4
            a = [axis[2], 0, -axis[0]]  # horizontal, across the axis
            b = [axis[1] * a[2] - axis[2] * a[1], axis[2] * a[0] - axis[0] * a[2], axis[0] * a[1] - axis[1] * a[0]]
            for _, d in cone[1:]:
                self.assertAlmostEqual(sum(x * x for x in d), 1, delta=1e-15)
                sine = math.dist(d, axis) / 2
                angles.append(math.degrees(2 * math.asin(sine)))
                quadrants[(sum(x * y for x, y in zip(d, a)) > 0) + 2 * (sum(x * y for x, y in zip(d, b)) > 0)] += 1
            self.assertAlmostEqual(max(angles), 1, delta=1e-9)
            self.assertEqual(angles, sorted(angles))
            # Even over the disc: a quarter of the rays within half of the radius, and in each quadrant.
            self.assertAlmostEqual(sum(x <= 0.5 for x in angles), samples / 4, delta=2)
            self.assertTrue(all(abs(count - samples / 4) <= 4 for count in quadrants), quadrants)

    def test_noise_and_dropout_are_what_the_documents_say(self):
        fields = ["t", "distance", "position", "node_id"]
        true = self.closest({"generator": SCAN, "fields": fields}).json()
        rays = self.make(SCAN)
        noisy = self.closest({"generator": {**SCAN, "noise": 0.25, "dropout": 0.2, "seed": 77}, "fields": fields}).json()
        dropped = hits = 0
        for i, (origin, d) in enumerate(rays):
            numbers = stream_of(77, i)
            if next(numbers) < 0.2 or true["t"][i] is None:
                dropped += true["t"][i] is not None
                self.assertEqual((noisy["t"][i], noisy["node_id"][i]), (None, -1))
                continue
            hits += 1
            error = 0.0
            for _ in range(12):
                error += next(numbers)
            t = max(true["t"][i] + 0.25 * (error - 6), 1)
            self.assertEqual((noisy["t"][i], noisy["node_id"][i]), (t, true["node_id"][i]))
            self.assertEqual(noisy["position"][3 * i:3 * i + 3], [o + t * x for o, x in zip(origin, d)])
            self.assertAlmostEqual(noisy["distance"][i], t, delta=1e-12)
        self.assertGreater(hits, 100)
        self.assertTrue(0.1 < dropped / (dropped + hits) < 0.3)

    def test_errors_of_ranges_have_their_deviation(self):
        plain = {"kind": "lidar", "position": [3, 100, 5], "forward": [0, -1, 0], "up": [1, 0, 0], "firings": [[0, 0]], "azimuths": 20000,
                 "sector": [0, 0.001]}
        true = self.closest({"generator": plain, "fields": ["t"]}).json()["t"]
        noisy = self.closest({"generator": {**plain, "noise": 0.5, "seed": 3}, "fields": ["t"]}).json()["t"]
        errors = [b - a for a, b in zip(true, noisy)]
        mean = sum(errors) / len(errors)
        deviation = math.sqrt(sum((x - mean)**2 for x in errors) / len(errors))
        self.assertAlmostEqual(mean, 0, delta=0.02)
        self.assertAlmostEqual(deviation, 0.5, delta=0.01)
        self.assertEqual(len({x for x in noisy}), len(noisy), "each ray has its own error")

    def test_noise_does_not_depend_on_batches_and_formats(self):
        noise = {**SCAN, "noise": 0.1, "dropout": 0.1, "seed": 5, "returns": 3}
        body = {"generator": noise, "fields": ["t", "distance", "position", "instance", "triangle"]}
        binary = self.closest(body, "-H", "Accept: application/octet-stream").body
        self.assertEqual(self.closest(body, "-H", "Accept: application/octet-stream").body, binary)
        columns, text = unpack(binary), self.closest(body).json()
        self.assertEqual([None if x == math.inf else x for x in columns["t"]], text["t"])
        # The first of several returns has the error of the only one.
        one = self.closest({**body, "generator": {**noise, "returns": 1}}).json()["t"]
        self.assertEqual(text["t"][::3], one)
        whole = self.closest({**body, "generator": {**noise, "azimuths": 45, "sector": [0, 180]}}).json()["t"]
        self.assertEqual(text["t"][:len(whole)], whole, "the error of a ray depends on its number alone")

    def test_pictures_of_node_colours_and_shades(self):
        nodes = read_floats(self.closest({"generator": VIEW, "image": "node"}, "-H", "Accept: image/x-portable-floatmap").body)[2]
        colours = read_png(self.closest({"generator": VIEW, "image": "node_colours"}).body)[2]
        seen = {}
        for row, colour_row in zip(nodes, colours):
            for x, node in enumerate(row):
                colour = colour_row[3 * x:3 * x + 3]
                expected = [round(65535 * (part / 255) ** 2) for part in node_colour(int(node))] if node >= 0 else [0, 0, 0]
                self.assertEqual(colour, expected)
                seen[node] = tuple(colour)
        self.assertGreater(len(seen), 8)
        # A colour has 24 bits, of which a hue uses some: nearly all nodes differ.
        self.assertGreater(len(set(seen.values())), 0.95 * len(seen))
        answer = self.closest({"generator": VIEW, "fields": ["normal", "material_id"]}).json()
        rays = self.make(VIEW)
        shades = read_floats(self.closest({"generator": VIEW, "image": "shaded"}, "-H", "Accept: image/x-portable-floatmap").body)[2]
        flat = [value for row in shades for value in row]
        by_material = {}
        for i, (_, d) in enumerate(rays):
            normal = answer["normal"][3 * i:3 * i + 3]
            if normal[0] is None:
                self.assertEqual(flat[3 * i:3 * i + 3], [0, 0, 0])
                continue
            along = abs(sum(a * b for a, b in zip(d, normal))) / math.sqrt(sum(x * x for x in d))
            base = [value / (0.25 + 0.75 * along) for value in flat[3 * i:3 * i + 3]]
            known = by_material.setdefault(answer["material_id"][i], base)
            for a, b in zip(base, known):
                self.assertAlmostEqual(a, b, delta=1e-6)
        self.assertGreater(len(by_material), 1)
        png = read_png(self.closest({"generator": VIEW, "image": "shaded"}).body)[2]
        for a, b in zip((value for row in png for value in row), flat):
            self.assertAlmostEqual(a, 65535 * b, delta=0.51)

    def test_faults_are_named(self):
        pinhole = {"kind": "pinhole", "width": 4, "height": 3}
        lidar = {"kind": "lidar", "azimuths": 5, "elevations": [0]}
        eye = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        for generator, code, pointer in [
                ({**pinhole, "pixels": [[0, 0], [4, 0]]}, "NUMBER_OUT_OF_RANGE", "/generator/pixels/1"),
                ({**pinhole, "pixels": [[0, 3]]}, "NUMBER_OUT_OF_RANGE", "/generator/pixels/0"),
                ({**pinhole, "pixels": [[0]]}, "LENGTH_WRONG", "/generator/pixels/0"),
                ({**pinhole, "pixels": [[0, 1, 2]]}, "LENGTH_WRONG", "/generator/pixels/0"),
                ({**pinhole, "pixels": [[0.5, 1]]}, "NUMBER_OUT_OF_RANGE", "/generator/pixels/0/0"),
                ({**pinhole, "crop": [2, 0, 3, 1]}, "NUMBER_OUT_OF_RANGE", "/generator/crop"),
                ({**pinhole, "crop": [0, 0, 3]}, "LENGTH_WRONG", "/generator/crop"),
                ({**pinhole, "crop": [0, 0, 1, 1], "pixels": []}, "KEYS_MIXED", "/generator"),
                ({**pinhole, "fov_x": 60, "fov_y": 60}, "KEYS_MIXED", "/generator"),
                ({**pinhole, "fov_x": 60, "intrinsics": [1, 1, 0, 0]}, "KEYS_MIXED", "/generator"),
                ({**pinhole, "fov_x": 0}, "NUMBER_OUT_OF_RANGE", "/generator/fov_x"),
                ({**pinhole, "intrinsics": [0, 1, 0, 0]}, "NUMBER_OUT_OF_RANGE", "/generator/intrinsics"),
                ({**pinhole, "extrinsic": eye[:3]}, "LENGTH_WRONG", "/generator/extrinsic"),
                ({**pinhole, "extrinsic": [*eye[:2], [0, 0, -1, 0], eye[3]]}, "GENERATOR_POSE", "/generator/extrinsic"),
                ({**pinhole, "extrinsic": [*eye[:2], [0, 0, 2, 0], eye[3]]}, "GENERATOR_POSE", "/generator/extrinsic"),
                ({**pinhole, "extrinsic": [*eye[:3], [0, 0, 0, 2]]}, "GENERATOR_POSE", "/generator/extrinsic"),
                ({**pinhole, "extrinsic": eye, "position": [0, 0, 0]}, "KEYS_MIXED", "/generator/extrinsic"),
                ({**pinhole, "sector": [0, 1]}, "KEY_UNKNOWN", "/generator/sector"),
                ({**lidar, "crop": [0, 0, 1, 1]}, "KEY_UNKNOWN", "/generator/crop"),
                ({**lidar, "sector": [10, 10]}, "NUMBER_OUT_OF_RANGE", "/generator/sector"),
                ({**lidar, "sector": [0, 361]}, "NUMBER_OUT_OF_RANGE", "/generator/sector"),
                ({**lidar, "firings": [[0, 0]]}, "KEYS_MIXED", "/generator"),
                ({"kind": "lidar", "azimuths": 5}, "KEY_MISSING", "/generator"),
                ({"kind": "lidar", "azimuths": 5, "firings": [[0]]}, "LENGTH_WRONG", "/generator/firings/0"),
                ({**lidar, "divergence": 1}, "KEY_MISSING", "/generator"),
                ({**lidar, "samples": 4}, "KEY_MISSING", "/generator"),
                ({**lidar, "divergence": 90, "samples": 4}, "NUMBER_OUT_OF_RANGE", "/generator/divergence"),
                ({**lidar, "divergence": 1, "samples": 1}, "NUMBER_OUT_OF_RANGE", "/generator/samples"),
                ({**lidar, "noise": -1}, "NUMBER_OUT_OF_RANGE", "/generator/noise"),
                ({**lidar, "dropout": 1.5}, "NUMBER_OUT_OF_RANGE", "/generator/dropout"),
                ({**lidar, "seed": 1}, "KEY_MISSING", "/generator"),
                ({"kind": "lidar", "azimuths": 4096, "elevations": [0] * 64, "divergence": 1, "samples": 65}, "RAYS_TOO_MANY", "/generator")]:
            with self.subTest(generator=generator):
                answer = self.server.query("six", "closest", {"generator": generator})
                self.assertEqual((answer.json()["code"], answer.json()["errors"][0]["pointer"]), (code, pointer), answer.body)
        for kind in ("any", "count", "all"):
            answer = self.server.query("six", kind, {"generator": {**lidar, "dropout": 0.5}})
            self.assertEqual((answer.json()["code"], answer.json()["errors"][0]["pointer"]), ("KEY_UNKNOWN", "/generator/dropout"))
        answer = self.server.query("six", "closest", {"generator": {**pinhole, "pixels": [[0, 0]]}, "image": "depth"})
        self.assertEqual((answer.json()["code"], answer.json()["errors"][0]["pointer"]), ("IMAGE_WITHOUT_PIXELS", "/image"))


if __name__ == "__main__":
    case_report.main()
