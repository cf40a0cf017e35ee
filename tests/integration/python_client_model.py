"""What a scene answers to rays and points, without the client: exact rational arithmetic over the triangles for rays, one
plain JSON request for each point, box and pair. Answers are kept.
"""

import http.client
import json
import math
import re
from fractions import Fraction
from pathlib import Path

# Kind and width of each field of a hit.
KINDS = {name: (kind, int(width)) for name, kind, width in re.findall(
    r'^HIT_FIELD\(\w+, "(\w+)", k(\w+), (\d),', (Path(__file__).parents[2] / "proto/hit_fields.def").read_text(encoding="utf-8"), re.MULTILINE)}


def _of(*kinds):
    return {name for name, (kind, _) in KINDS.items() if kind in kinds}


COSTS = {"cost_nodes", "cost_blocks"}  # Of misses too, and of the trees that are built: work_test.py judges them.
DISTANCES, IDS, FLAGS, TEXTS = _of("Number"), _of("Index", "Id") - COSTS, _of("Flag"), _of("Text")
WIDTHS = {name: width for name, (kind, width) in KINDS.items() if kind == "Vector"}
RAY_FIELDS = [*sorted(DISTANCES), *WIDTHS, *sorted(IDS), *sorted(FLAGS), *sorted(TEXTS)]
POINT_FIELDS = [name for name in RAY_FIELDS if name != "t" and name not in TEXTS]
FAULTS = ["", "RAY_NOT_FINITE", "RAY_DIRECTION_ZERO", "RAY_LIMIT_NAN", "RAY_LIMITS_REVERSED"]


def missing(name):
    """What stands in a column where there is nothing."""
    if name in WIDTHS:
        return [math.nan] * WIDTHS[name]
    return math.inf if name in DISTANCES else -1 if name in IDS else False if name in FLAGS or name == "hit" else None


def fault(origin, direction, tmin, tmax):
    """The number in docs/reference/binary.md of what is wrong with a ray; 0: nothing."""
    if not all(map(math.isfinite, [*origin, *direction])):
        return 1
    if not any(direction):
        return 2
    if math.isnan(tmin) or math.isnan(tmax):
        return 3
    return 4 if tmin > tmax else 0


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def meeting(corners, origin, direction):
    """t of the one common point of a line and a closed triangle; None: there is none; NotImplemented: the line lies in its plane."""
    a, b, c = corners
    edge = [[y - x for x, y in zip(first, second)] for first, second in ((a, b), (b, c), (c, a))]
    normal = cross(edge[0], edge[1])
    slope, height = dot(normal, direction), dot(normal, [x - y for x, y in zip(a, origin)])
    if slope == 0:
        return None if height else NotImplemented
    t = height / slope
    point = [x + t * y for x, y in zip(origin, direction)]
    sides = (dot(normal, cross(side, [x - y for x, y in zip(point, corner)])) for side, corner in zip(edge, corners))
    return t if all(side >= 0 for side in sides) else None


class Model:
    """Of the scenes of a server. Numbers are float, rows are tuples."""

    def __init__(self, port, scenes):
        self.connection = http.client.HTTPConnection("127.0.0.1", port)
        self.kept = {}
        self.triangles = {scene: self.corners_of(scene) for scene in scenes}

    def close(self):
        self.connection.close()

    def ask(self, path, body=None):
        text = None if body is None else json.dumps(body)
        key = path, text
        if key not in self.kept:
            if len(self.kept) > 200_000:
                self.kept.clear()
            self.connection.request("GET" if body is None else "POST", path, text, {"Content-Type": "application/json"})
            answer = self.connection.getresponse()
            self.kept[key] = answer.status, json.loads(answer.read())
        return self.kept[key]

    def told(self, scene, what, body):
        status, answer = self.ask(f"/v1/scenes/{scene}/{what}", body)
        if status != 200:
            raise AssertionError(f"{what} {body}: {status} {answer}")
        return answer

    def corners_of(self, scene):
        """((instance, primitive, triangle), corners) of every triangle: all have one primitive."""
        triangles = []
        for instance in range(100):
            for triangle in range(100):
                status, answer = self.ask(f"/v1/scenes/{scene}/triangles?ids={instance}.0.{triangle}")
                if status != 200:
                    break
                corners = [list(map(Fraction, corner)) for corner in answer["triangles"][0]["corners"]]
                triangles.append(((instance, 0, triangle), corners))
            if triangle == 0:
                return triangles
        raise AssertionError("too many instances")

    def row(self, hit):
        """A hit of JSON with what it says nothing of."""
        return {**{name: missing(name) if value is None else value for name, value in hit.items()}, "hit": True}

    def line(self, scene, origin, direction):
        """The hits of a whole line as (t, row), None if it lies in the plane of a triangle."""
        key = scene, origin, direction
        if key in self.kept:
            return self.kept[key]
        exact = [Fraction(x) for x in origin], [Fraction(x) for x in direction]
        met = [(meeting(corners, *exact), ids) for ids, corners in self.triangles[scene]]
        if any(t is NotImplemented for t, _ in met):
            self.kept[key] = None
            return None
        met = sorted((t, ids) for t, ids in met if t is not None)
        rounded = []
        for t, ids in met:
            try:
                rounded.append((float(t), *ids))
            except OverflowError:
                rounded.append((math.inf if t > 0 else -math.inf, *ids))
        if any(math.isinf(t) for t, *_ in rounded):
            # JSON can neither ask for such a t nor tell it: the direction times a power of two has other t, but the hits.
            rows = self.asked(scene, origin, tuple(x * 2.0 ** 1000 for x in direction), -math.inf, math.inf)
            for row, (t, *_) in zip(rows, rounded):
                row["t"] = t
                row["distance"] = t if math.isinf(t) else row["distance"]
        else:
            rows = self.asked(scene, origin, direction, -math.inf, math.inf)
        if [(row["t"], row["instance"], row["primitive"], row["triangle"]) for row in rows] != rounded:
            raise AssertionError(f"{key}: exact {rounded}, the server {rows}")
        self.kept[key] = [(t, row) for (t, _), row in zip(met, rows)]
        return self.kept[key]

    def asked(self, scene, origin, direction, tmin, tmax):
        """The hits of a ray as plain JSON tells them."""
        if tmin == math.inf or tmax == -math.inf:
            return []
        ray = {"origin": origin, "direction": direction, "tmin": max(tmin, -1.7976931348623157e308)}
        ray.update({} if tmax == math.inf else {"tmax": tmax})
        body = {"rays": [ray], "fields": RAY_FIELDS}
        return list(map(self.row, self.told(scene, "rays:all", body)["results"][0]["hits"]))

    def hits(self, scene, origin, direction, tmin, tmax):
        """Rows of a ray within its limits, in order."""
        line = self.line(scene, origin, direction)
        if line is None:
            return self.asked(scene, origin, direction, tmin, tmax)
        return [row for t, row in line if (tmin == -math.inf or tmin < math.inf and t >= Fraction(tmin)) and
                (tmax == math.inf or tmax > -math.inf and t <= Fraction(tmax))]

    def closest_points(self, scene, point):
        hit = self.told(scene, "points:closest", {"points": [point], "fields": POINT_FIELDS})["hits"][0]
        return self.row(hit)

    def nearest(self, scene, point, count):
        body = {"points": [point], "count": count, "fields": POINT_FIELDS}
        return list(map(self.row, self.told(scene, "points:nearest", body)["results"][0]["hits"]))

    def distance(self, scene, point):
        answer = self.told(scene, "points:distance", {"points": [point], "method": "winding"})
        return {name: answer[name][0] for name in ("distance", "reliable", "winding")}

    def generated(self, generator):
        """(origin, direction, tmin, tmax) of each ray."""
        status, rays = self.ask("/v1/rays:generate", {"generator": generator})
        if status != 200:
            raise AssertionError(rays)
        triples = [[tuple(map(float, rays[name][i:i + 3])) for i in range(0, len(rays[name]), 3)] for name in ("origins", "directions")]
        return list(zip(*triples, rays["tmin"], (math.inf if x is None else x for x in rays["tmax"])))
