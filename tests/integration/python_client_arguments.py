"""Random arguments for the Python client, right and wrong, with the numbers and the shape that they stand for."""

import array
import math

try:
    import numpy
except ImportError:
    numpy = None

ORIGINS = [(-10, 1, 0), (1, 10, 0), (3, 10, 0), (0.5, -0.5, 5), (-0.25, 0.5, 5), (0, 0, 5), (0.1, 0.3, 7), (-5, 3, 0.5), (0, 0, 0),
           (2.5, 1.25, -3), (100, 50, 25), (-6, 0, 2), (0.7, 0.2, -4), (-4, 30, 1), (1, 1, 1)]
DIRECTIONS = [(1, 0, 0), (0, -1, 0), (0, 0, -1), (0, 0, 1), (-1, 0, 0), (1, 0.5, 0), (0.1, -0.7, 0.3), (0, -0.25, -1), (-3, -2, -1),
              (0, 2, 0), (1, 1, 1), (0, 0, -5)]
LIMITS = [0, 1, 4.5, 5, 7.5, 8, -3, 0.1, 100, 6.5]
FLOATS, INTEGERS = ["f8", "f4", ">f8", ">f4", "f2"], ["i1", "i2", "i4", "i8", ">i4", ">i8"]
# Dtypes without numbers, as a whole array.
NO_NUMBERS = ["bool", "complex", "object", "str", "m8[s]", "longdouble", "masked"]
NO_NUMBER = [True, "1", None, 1j, b"1", 10 ** 400, {}]


class Argument:
    """`value` goes to the client. `rows` are its numbers as nested lists, `shape` their shape; `good`: they are numbers."""

    def __init__(self, value, rows, shape, good=True):
        self.value, self.rows, self.shape, self.good = value, rows, tuple(shape), good

    def flat(self):
        """Its numbers, row by row."""
        numbers = [self.rows]
        while any(isinstance(each, list) for each in numbers):
            numbers = [x for row in numbers for x in row]
        return numbers

    def triples(self):
        numbers = self.flat()
        return [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]


class Maker:
    """Draws arguments."""

    def __init__(self, draw):
        self.draw = draw

    def chance(self, percent):
        return self.draw.random() * 100 < percent

    def triples(self, pool, lead):
        """A float64 array of this leading shape; some rows are constant, so that they can be broadcast."""
        rows = [self.draw.choice(pool) for _ in range(math.prod(lead))]
        if rows and self.chance(10):
            rows = [rows[0]] * len(rows)
        return numpy.array(rows, "f8").reshape(*lead, 3)

    def distorted(self, table):
        """The array in another shape; it may be a right one by chance."""
        draw = self.draw
        ways = [lambda: table.T, lambda: table[..., :2], lambda: numpy.concatenate([table, table], -1), lambda: table.reshape(-1),
                lambda: table[None], lambda: table[None, None], lambda: table[:, None], lambda: table[:-1], lambda: table[:1],
                lambda: table[:0], lambda: numpy.zeros(0), lambda: numpy.array(1.0), lambda: table.reshape(-1)[:3],
                lambda: numpy.swapaxes(table, 0, table.ndim - 1), lambda: numpy.repeat(table, 2, 0), lambda: table[..., :0],
                lambda: table.reshape(-1, 1), lambda: numpy.roll(table, 1, -1)]
        return numpy.array(draw.choice(ways)())

    def poisoned(self, table):
        if table.size:
            table = table.copy()
            table.flat[self.draw.randrange(table.size)] = self.draw.choice([math.nan, math.inf, -math.inf])
        return table

    def laid_out(self, table):
        """The same numbers in another layout of memory."""
        draw, shape = self.draw, table.shape
        way = draw.randrange(8)
        if way == 0 and table.ndim:
            return numpy.asfortranarray(table)
        if way == 1 and table.ndim:
            wide = numpy.full([2 * size + 1 for size in shape], 77, table.dtype)
            view = wide[tuple(slice(0, 2 * size, 2) for size in shape)]
            view[...] = table
            return view
        if way == 2 and table.ndim:
            back = tuple(slice(None, None, -1) for _ in shape)
            return table[back].copy()[back]
        if way == 3 and table.ndim > 1 and table.size and (table == table[:1]).all():
            return numpy.broadcast_to(table[0].copy(), shape)
        if way == 4 and table.size:
            raw = numpy.frombuffer(b"\0" + table.tobytes(), "u1")[1:]  # Not aligned, not writeable.
            return raw.view(table.dtype).reshape(shape)
        if way == 5 and table.ndim == 2:
            return numpy.matrix(table)
        if way == 6 and table.ndim > 1:
            return numpy.ascontiguousarray(table.T).T
        return table

    def as_array(self, table):
        draw = self.draw
        if self.chance(3):
            return self.no_numbers(table)
        whole = numpy.isfinite(table).all() and (numpy.rint(table) == table).all() and (numpy.abs(table) < 128).all()
        table = table.astype(draw.choice(FLOATS + INTEGERS if whole else FLOATS))
        rows = table.astype("f8").tolist()
        return Argument(self.laid_out(table), rows, table.shape)

    def no_numbers(self, table):
        kind = self.draw.choice(NO_NUMBERS)
        if kind == "masked":
            value = numpy.ma.masked_array(table, numpy.zeros(table.shape, bool))
        elif kind == "m8[s]":
            value = numpy.nan_to_num(table, posinf=0, neginf=0).astype("i8").astype(kind)
        else:
            value = table.astype(kind)
        return Argument(value, None, table.shape, good=False)

    def as_sequence(self, table, plain):
        """Lists, tuples, rows that are arrays; `plain`: numpy is not there for the client."""
        draw, rows = self.draw, table.tolist()
        shape = self.shape_of(rows)
        if self.chance(4) and table.size:
            return Argument(self.spoiled(rows, draw.choice(NO_NUMBER)), None, shape, good=False)
        if self.chance(2) and len(shape) > 1 and len(rows) > 1:
            rows[-1] = rows[-1] + rows[-1] if rows[-1] else [0.0]
            return Argument(rows, None, shape, good=False)
        way = draw.randrange(6)
        value = rows
        if way == 1 and isinstance(rows, list):
            value = tuple(map(tuple, rows)) if len(shape) > 1 else tuple(rows)
        elif way == 2 and len(shape) > 1 and not plain:
            value = [numpy.array(row, "f8") for row in rows]
        elif way == 3 and len(shape) == 1:
            value = array.array("d", rows)
        elif way == 4 and len(shape) == 2:
            value = [[int(x) if math.isfinite(x) and x == int(x) else x for x in row] for row in rows]
        elif way == 5 and len(shape) == 2 and not plain:
            value = [tuple(numpy.float64(x) for x in row) for row in rows]
        return Argument(value, rows, shape)

    def shape_of(self, rows):
        shape = []
        while isinstance(rows, list):
            shape.append(len(rows))
            rows = rows[0] if rows else None
        return tuple(shape)

    def spoiled(self, rows, wrong):
        """With one number replaced by what is none."""
        if not isinstance(rows, list):
            return wrong
        place = rows
        while isinstance(place[0], list):
            place = self.draw.choice(place)
        place[self.draw.randrange(len(place))] = wrong
        return rows

    def contained(self, table, plain):
        return self.as_sequence(table, plain) if plain or self.chance(25) else self.as_array(table)

    def points(self, pool, lead, plain, trouble):
        table = self.triples(pool, lead)
        if trouble and self.chance(50):
            table = self.distorted(table)
        elif trouble and self.chance(30):
            table = self.poisoned(table)
        return self.contained(table, plain)

    def limit(self, lead, plain, trouble):
        if self.chance(50):
            return None
        shape = () if self.chance(40) else lead
        table = numpy.array([self.draw.choice(LIMITS) for _ in range(math.prod(shape))], "f8").reshape(shape)
        if self.chance(15):
            table = numpy.full_like(table, self.draw.choice([math.inf, -math.inf, 4.5]))
        if trouble and self.chance(40):
            table = numpy.array(self.draw.choice([lambda: numpy.ravel(table), lambda: table[None], lambda: numpy.ravel(table)[:-1],
                                                  lambda: table[..., None], lambda: numpy.full(2, 5.0)])())
        elif trouble and self.chance(30):
            table = self.poisoned(table)
        limit = self.contained(table, plain)
        return None if limit.value is None else limit
