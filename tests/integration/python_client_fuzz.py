"""Random calls of proto/python/sightline.py against a model: right and wrong shapes, layouts, dtypes, lists, NaN and infinities.

Each call must have the answer of the model, with the documented type and shape, or must raise the documented exception
if its arguments are wrong. An answer to wrong arguments and a wrong answer count as silent.

    python_client_fuzz.py BINARY [--calls N] [--seed S]
"""

import argparse
import collections
import math
import random
import sys
import time
from pathlib import Path

try:
    import numpy
except ImportError:
    numpy = None

import python_client_model as model_of
from python_client_arguments import DIRECTIONS, FLOATS, INTEGERS, ORIGINS, Maker

SCENES = ("six", "painted")
PRELOAD = [word for scene in SCENES for word in ("--preload", f"{scene}=demo:{scene}")]
GENERATORS = [
    {"kind": "pinhole", "position": [-10, 1, 0], "forward": [1, 0, 0], "width": 3, "height": 2},
    {"kind": "orthographic", "position": [0.1, 0.2, 9], "extent_y": 6, "width": 4, "height": 4, "range": [1, 50]},
    {"kind": "lidar", "position": [-10, 1, 0], "elevations": [0, 5], "azimuths": 4, "range": [0, 50]},
]


class Refused(Exception):
    """What the model expects in place of an answer: the name of the exception, and the code of a SightlineError."""

    def __init__(self, kind, code=None):
        super().__init__(kind, code)
        self.kind, self.code = kind, code


def points_shape(argument, images=True):
    """The leading shape, by the documented rule."""
    if argument.good and argument.shape == (0,) and isinstance(argument.value, (list, tuple)):
        return (0,)
    if not argument.good or argument.shape[-1:] != (3,) or len(argument.shape) not in ((2, 3) if images else (2,)):
        raise Refused("ValueError")
    return argument.shape[:-1]


def finite(rows):
    if not all(math.isfinite(x) for row in rows for x in row):
        raise Refused("ValueError")
    return rows


class Fuzz:
    def __init__(self, server, client_module, seed):
        self.module, self.draw = client_module, random.Random(seed)
        self.make = Maker(self.draw)
        self.model = model_of.Model(server.port, SCENES)
        self.client = client_module.Sightline(server.url)
        self.counts = collections.Counter()
        self.wrong = []

    def close(self):
        self.client.close()
        self.model.close()

    def run(self, calls):
        methods = [(self.rays, 60), (self.generated, 4), (self.near, 18), (self.inside, 5), (self.visibility, 5), (self.boxes, 4),
                   (self.triangles, 4)]
        kinds, weights = zip(*methods)
        true_numpy = self.module.numpy
        try:
            for number in range(calls):
                self.plain = self.draw.random() < 0.15
                self.module.numpy = None if self.plain else true_numpy
                self.one(number, self.draw.choices(kinds, weights)[0])
        finally:
            self.module.numpy = true_numpy

    def one(self, number, kind):
        call, expect = kind()
        try:
            expected, refused = expect(), None
        except Refused as refusal:
            expected, refused = None, refusal
        try:
            answer, raised = call(), None
        except Exception as error:  # One that is not documented is a fault too.
            answer, raised = None, error
        told = f"call {number}, {call.text}"
        if refused is None and raised is None:
            try:
                self.compare(expected, answer)
                self.counts["answered"] += 1
            except AssertionError as fault:
                self.counts["silent"] += 1
                self.wrong.append(f"{told}: {fault}")
        elif refused is not None and raised is not None:
            if type(raised).__name__ != refused.kind or (refused.code and raised.code != refused.code):
                self.counts["other refusals"] += 1
                self.wrong.append(f"{told}: expected {refused}, not {raised!r}")
            self.counts["refused"] += 1
        elif raised is None:
            self.counts["silent"] += 1
            self.wrong.append(f"{told}: expected {refused}, answered {answer}")
        else:
            self.counts["wrong refusals"] += 1
            self.wrong.append(f"{told}: refused with {raised!r}")

    def call(self, method, /, *arguments, **options):
        def ask():
            return getattr(self.client, method)(*arguments, **options)
        ask.text = f"{'without' if self.plain else 'with'} numpy: {method}{arguments!r} {options!r}"
        return ask

    # What is compared.

    def compare(self, expected, answer):
        if not isinstance(expected, dict):
            expected, answer = {"": expected}, {"": answer}
        if set(answer) - {"unreliable"} != set(expected):
            raise AssertionError(f"columns {sorted(answer)}, expected {sorted(expected)}")
        for name, column in expected.items():
            self.compare_column(name, column, answer[name])

    def compare_column(self, name, expected, got):
        """`expected` is (dtype, shape, flat list of numbers), or what the answer equals."""
        if not isinstance(expected, tuple):
            if got != expected:
                raise AssertionError(f"{name}: {got}, expected {expected}")
            return
        dtype, shape, values = expected
        if dtype == "text" or self.plain:
            nested = self.nested(values, shape)
            if not isinstance(got, list) or repr(got) != repr(nested):
                raise AssertionError(f"{name}: {got!r}, expected {nested!r}")
            return
        if type(got) is not numpy.ndarray or got.dtype != dtype or got.shape != shape:
            raise AssertionError(f"{name}: {type(got)} {getattr(got, 'dtype', '')} {getattr(got, 'shape', '')}, expected {dtype} {shape}")
        if not numpy.array_equal(got.reshape(-1), numpy.array(values, dtype), equal_nan=dtype == "float64"):
            raise AssertionError(f"{name}: {got.tolist()}, expected {values}")

    def nested(self, values, shape):
        if len(shape) == 1:
            return list(values)
        size = math.prod(shape[1:])
        return [self.nested(values[i * size:(i + 1) * size], shape[1:]) for i in range(shape[0])]

    def column(self, name, rows, lead):
        if name in model_of.TEXTS:
            return "text", lead, [row[name] for row in rows]
        if name in model_of.WIDTHS:
            flat = [math.nan if x is None else float(x) for row in rows for x in row[name]]
            return "float64", (*lead, model_of.WIDTHS[name]), flat
        if name in model_of.DISTANCES:
            return "float64", lead, [float(row[name]) for row in rows]
        return ("int64" if name in model_of.IDS else "bool"), lead, [row[name] for row in rows]

    def columns(self, fields, rows, lead):
        """Rows are hits, None where there is none."""
        names = [*fields, "hit"]
        filled = [row or {name: model_of.missing(name) for name in names} for row in rows]
        return {name: self.column(name, filled, lead) for name in names}

    # Rays.

    def lead(self):
        return self.draw.choice([(1,), (2,), (3,), (3,), (4,), (5,), (7,), (0,), (2, 2), (1, 3), (2, 3), (3, 2), (1, 1), (0, 2), (2, 0)])

    def fields(self, names):
        if self.draw.random() < 0.3:
            return None
        return self.draw.sample(names, self.draw.randint(1, 5))

    def rays(self):
        make, draw = self.make, self.draw
        scene, lead = draw.choice(SCENES), self.lead()
        trouble = draw.random() < 0.45
        pool = DIRECTIONS + [(0, 0, 0), (1e-310, 0, 0), (0, 0, -1e-310)] if draw.random() < 0.1 else DIRECTIONS
        origins, directions = make.points(ORIGINS, lead, self.plain, trouble), make.points(pool, lead, self.plain, trouble)
        limits = {name: make.limit(lead, self.plain, trouble) for name in ("tmin", "tmax")}
        kind = draw.choices(["closest", "any", "count", "all"], [50, 15, 15, 20])[0]
        names = model_of.RAY_FIELDS if draw.random() < 0.35 else [name for name in model_of.RAY_FIELDS if name not in model_of.TEXTS]
        fields = self.fields(names) if kind in ("closest", "all") else None
        options = {} if fields is None else {"fields": draw.choice([list, tuple])(fields)}
        if draw.random() < 0.15:
            options["on_invalid"] = "mark"
        if kind == "all" and draw.random() < 0.3:
            options["max_hits"] = 2
        given = {name: limit.value for name, limit in limits.items() if limit is not None}
        call = self.call(kind, scene, origins.value, directions.value, **given, **options)
        return call, lambda: self.expected_rays(scene, kind, origins, directions, limits, fields, options)

    def expected_rays(self, scene, kind, origins, directions, limits, fields, options):
        lead = points_shape(origins)
        if points_shape(directions) != lead:
            raise Refused("ValueError")
        columns, count = {}, math.prod(lead)
        for name, usual in (("tmin", 0.0), ("tmax", math.inf)):
            limit = limits[name]
            if limit is None:
                columns[name] = [usual] * count
            elif limit.good and limit.shape in ((), lead):
                columns[name] = limit.flat() * (count if limit.shape == () else 1)
            else:
                raise Refused("ValueError")
        texts = not model_of.TEXTS.isdisjoint(fields or ())
        marks = options.get("on_invalid") == "mark"
        rays = list(zip(origins.triples(), directions.triples(), columns["tmin"], columns["tmax"]))
        if texts or not marks:
            finite([*origins.triples(), *directions.triples()])
            # One number for all rays of an empty batch is not looked at.
            if any(math.isnan(x) for name in columns for x in columns[name]):
                raise Refused("ValueError")
            if texts and not (all(map(math.isfinite, columns["tmin"])) and all(x > -math.inf for x in columns["tmax"])):
                raise Refused("ValueError")
        faults = [model_of.fault(*ray) for ray in rays]
        if any(faults) and not marks:
            raise Refused("SightlineError", model_of.FAULTS[next(filter(None, faults))])
        return self.answer(scene, kind, rays, faults, lead, fields, options, marks)

    def answer(self, scene, kind, rays, faults, lead, fields, options, marks):
        hits = [[] if fault else self.model.hits(scene, *ray) for ray, fault in zip(rays, faults)]
        if kind == "any":
            return "bool", lead, [bool(each) for each in hits]
        if kind == "count":
            return "uint64", lead, list(map(len, hits))
        fields = fields or ("t", "instance", "primitive", "triangle")
        if kind == "closest":
            expected = self.columns(fields, [each[0] if each else None for each in hits], lead)
        else:
            kept = [each[:options.get("max_hits", len(each))] for each in hits]
            first = [0]
            for each in kept:
                first.append(first[-1] + len(each))
            expected = self.columns(fields, [row for each in kept for row in each], (first[-1],))
            expected.update(totals=("uint64", lead, list(map(len, hits))), first=("uint64", (len(first),), first))
        if marks:
            expected["invalid"] = "uint8", lead, faults
        return expected

    def generated(self):
        draw = self.draw
        generator, scene = draw.choice(GENERATORS), draw.choice(SCENES)
        kind = draw.choice(["closest", "any", "count", "all"])
        fields = self.fields(model_of.RAY_FIELDS) if kind in ("closest", "all") else None
        options = {} if fields is None else {"fields": fields}
        limits = {"tmax": 5} if draw.random() < 0.2 else {}
        sent = {name: numpy.array(value) if isinstance(value, list) and draw.random() < 0.5 and not self.plain else value
                for name, value in generator.items()}

        def expected():
            if limits:
                raise Refused("ValueError")
            rays = self.model.generated(generator)
            lead = (generator["height"], generator["width"]) if "width" in generator else (len(rays),)
            return self.answer(scene, kind, rays, [0] * len(rays), lead, fields, {}, False)
        return self.call(kind, scene, generator=sent, **limits, **options), expected

    # Points, boxes, ids.

    def near(self):
        draw = self.draw
        scene, lead = draw.choice(SCENES), self.lead()
        points = self.make.points(ORIGINS, lead, self.plain, draw.random() < 0.45)
        kind = draw.choice(["closest_points", "nearest", "distance"])
        fields = self.fields(model_of.POINT_FIELDS) if kind != "distance" else None
        options = {} if fields is None else {"fields": fields}
        count = draw.randint(1, 3)
        arguments = (scene, points.value) + ((count,) if kind == "nearest" else ())
        if kind == "distance":
            options["method"] = "winding"

        def expected():
            lead = points_shape(points)
            rows = finite(points.triples())
            names = fields or ("distance", "instance", "primitive", "triangle")
            if kind == "closest_points":
                return self.columns(names, [self.model.closest_points(scene, row) for row in rows], lead)
            if kind == "nearest":
                lists = [self.model.nearest(scene, row, count) for row in rows]
                first = [0]
                for each in lists:
                    first.append(first[-1] + len(each))
                columns = self.columns(names, [row for each in lists for row in each], (first[-1],))
                return {**columns, "first": ("uint64", (len(first),), first)}
            told = [self.model.distance(scene, row) for row in rows]
            kinds = (("distance", "float64", float), ("reliable", "bool", bool), ("winding", "int64", int))
            return {name: (dtype, lead, [kind(each[name]) for each in told]) for name, dtype, kind in kinds}
        return self.call(kind, *arguments, **options), expected

    def inside(self):
        scene = self.draw.choice(SCENES)
        points = self.make.points(ORIGINS, self.lead(), self.plain, self.draw.random() < 0.45)

        def expected():
            lead = points_shape(points)
            rows = finite(points.triples())
            told = [self.model.told(scene, "points:inside", {"points": [row]}) for row in rows]
            return {name: ("bool", lead, [each[name][0] is True for each in told]) for name in ("inside", "on_surface", "reliable")}
        return self.call("inside", scene, points.value), expected

    def visibility(self):
        draw = self.draw
        scene, each = draw.choice(SCENES), draw.random() < 0.5
        sizes = [(draw.randint(0, 4),)] * 2 if each and draw.random() < 0.8 else [(draw.randint(0, 4),), (draw.randint(0, 4),)]
        start, end = (self.make.points(ORIGINS, size, self.plain, draw.random() < 0.3) for size in sizes)

        def expected():
            lengths = [points_shape(points, images=False) for points in (start, end)]
            rows = [finite(points.triples()) for points in (start, end)]
            if each and lengths[0] != lengths[1]:
                raise Refused("ValueError")

            def sees(a, b):
                return self.model.told(scene, "visibility", {"from": [a], "to": [b], "pairing": "each"})["visible"]
            if each:
                return {"visible": ("bool", lengths[0], [sees(*pair) == "1" for pair in zip(*rows)])}
            return {"visible": ("bool", lengths[0] + lengths[1], [sees(a, b) == "1" for a in rows[0] for b in rows[1]])}
        return self.call("visibility", scene, start.value, end.value, **({"pairing": "each"} if each else {})), expected

    def boxes(self):
        draw, scene = self.draw, self.draw.choice(SCENES)
        boxes, plain, refused = [], [], None
        for _ in range(draw.randint(0, 3)):
            low = numpy.array([draw.randint(-8, 2) for _ in range(3)], "f8")
            sides = {"min": low, "max": low + draw.randint(0, 9)}
            plain.append({name: side.tolist() for name, side in sides.items()})
            wrong = draw.random()
            if wrong < 0.1:
                sides["min"], refused = sides["min"][:2], refused or "SightlineError"
            elif wrong < 0.2:
                sides["min"], refused = self.make.poisoned(sides["min"]), "ValueError"
            elif wrong < 0.25:
                sides["min"], refused = sides["min"].astype(bool), refused or "SightlineError"
            elif wrong < 0.3:
                sides["max"], refused = numpy.stack([sides["max"]] * 3), refused or "SightlineError"
            elif wrong < 0.7:
                sides = {name: self.make.laid_out(side.astype(draw.choice(FLOATS + INTEGERS))) for name, side in sides.items()}
            boxes.append({name: side.tolist() if self.plain else side for name, side in sides.items()})

        def expected():
            if refused:
                raise Refused(refused)
            return "uint64", (len(plain),), [self.model.told(scene, "boxes:count", {"boxes": [box]})["counts"][0] for box in plain]
        return self.call("boxes_count", scene, boxes), expected

    def triangles(self):
        draw = self.draw
        scene = draw.choice(SCENES)
        known = [ids for ids, _ in self.model.triangles[scene]]
        table = numpy.array([draw.choice(known) for _ in range(draw.randint(0, 4))], "i8").reshape(-1, 3)
        good = True
        if draw.random() < 0.4:
            table = self.make.distorted(table)
        if draw.random() < 0.2:
            table, good = table.astype(draw.choice(["f8", "bool", "str", "complex"])), False
        elif table.dtype.kind == "i":
            table = self.make.laid_out(table.astype(draw.choice(["i4", "i8", ">i8", "i2"])))
        as_list = self.plain or draw.random() < 0.4
        value = table.tolist() if as_list else table
        if as_list:
            shape = self.make.shape_of(value)
            empty = shape == (0,)
        else:
            shape, empty = table.shape, False

        def expected():
            if empty:
                return []
            if not good or table.dtype.kind not in "iu" or len(shape) != 2 or shape[1] != 3:
                raise Refused("ValueError")
            rows, kept = table.tolist(), []
            for row in rows:
                status, answer = self.model.ask(f"/v1/scenes/{scene}/triangles?ids={'.'.join(map(str, row))}")
                if status != 200:
                    raise Refused("SightlineError", answer["code"])
                kept += answer["triangles"]
            return kept
        return self.call("triangles", scene, value), expected

    def text(self):
        return (f"{self.counts['answered']} answered, {self.counts['refused']} refused as documented, {self.counts['silent']} silent "
                f"wrong results, {self.counts['wrong refusals']} right calls refused, {self.counts['other refusals']} other exceptions")


def run(server, source, calls, seed):
    """A Fuzz after so many calls."""
    sys.path.insert(0, str(Path(source, "proto/python")))
    import sightline
    fuzz = Fuzz(server, sightline, seed)
    try:
        fuzz.run(calls)
    finally:
        fuzz.close()
    return fuzz


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--calls", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0, help="0: another one each time")
    options = parser.parse_args()
    if numpy is None:
        print("SKIPPED: numpy is not installed")
        return 0
    seed = options.seed or random.SystemRandom().getrandbits(32)
    print(f"seed {seed}", flush=True)
    sys.argv = [sys.argv[0], options.binary]
    from sightline_server import SOURCE, Server  # takes the binary from the command line
    begin = time.monotonic()
    with Server(*PRELOAD, "--log-level", "warn") as server:
        fuzz = run(server, SOURCE, options.calls, seed)
    for line in fuzz.wrong[:20]:
        print(line)
    print(f"{options.calls} calls in {time.monotonic() - begin:.0f} s: {fuzz.text()}")
    return 1 if fuzz.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
