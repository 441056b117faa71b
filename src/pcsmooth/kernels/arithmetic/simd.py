"""Eight numbers at a time: numba types for a SIMD register of doubles and for a mask of it.

LLVM turns operations on its portable vector type into the widest instructions the processor has
(one of AVX-512, two of AVX, four of SSE or NEON), so the kernels say what happens in parallel
instead of hoping that a loop is recognised. `Lanes` support + - * / and comparisons with lanes
and floats; masks support & and |.
"""

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, models, overload, register_model

from pcsmooth.kernels.compiled import inner

#: Numbers in a register.
WIDTH = 8

_DOUBLES = ir.VectorType(ir.DoubleType(), WIDTH)
_FLAGS = ir.VectorType(ir.IntType(1), WIDTH)
_NUMBERS = ir.VectorType(ir.IntType(32), WIDTH)
_BYTE = ir.IntType(WIDTH)
_DOUBLE_BYTES = 8
_NUMBER_BYTES = 4


class _Lanes(types.Type):
    def __init__(self):
        super().__init__(name="Lanes")


class _Mask(types.Type):
    def __init__(self):
        super().__init__(name="Mask")


lanes_type = _Lanes()
mask_type = _Mask()


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes):
        super().__init__(manager, lanes, _DOUBLES)


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, mask):
        super().__init__(manager, mask, _FLAGS)


def _broadcast(builder, number_type, value):
    """Leave a register as it is, put a float into every lane."""
    if number_type == lanes_type:
        return value
    undefined = ir.Constant(_DOUBLES, ir.Undefined)
    first = builder.insert_element(undefined, value, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, undefined, zeros)


def _call(builder, name, result, arguments, **options):
    signature = ir.FunctionType(result, [argument.type for argument in arguments])
    function = cgutils.get_or_insert_function(builder.module, signature, name)
    return builder.call(function, arguments, **options)


def _is_number(number_type):
    return number_type == lanes_type or number_type == types.float64


def _define_operator(symbol, emit, result):
    """Make `symbol` work on lanes and floats."""

    @intrinsic
    def apply(_context, a, b):
        def generate(_context, builder, signature, arguments):
            pairs = zip(signature.args, arguments, strict=True)
            return emit(builder, *(_broadcast(builder, kind, value) for kind, value in pairs))

        return result(a, b), generate

    @overload(symbol)
    def _on_lanes(a, b):
        if lanes_type in (a, b) and _is_number(a) and _is_number(b):
            return lambda a, b: apply(a, b)
        return None


_define_operator(operator.add, ir.IRBuilder.fadd, lanes_type)
_define_operator(operator.sub, ir.IRBuilder.fsub, lanes_type)
_define_operator(operator.mul, ir.IRBuilder.fmul, lanes_type)
_define_operator(operator.truediv, ir.IRBuilder.fdiv, lanes_type)
_define_operator(operator.lt, lambda b, x, y: b.fcmp_ordered("<", x, y), mask_type)
_define_operator(operator.le, lambda b, x, y: b.fcmp_ordered("<=", x, y), mask_type)
_define_operator(operator.gt, lambda b, x, y: b.fcmp_ordered(">", x, y), mask_type)
_define_operator(operator.ge, lambda b, x, y: b.fcmp_ordered(">=", x, y), mask_type)
_define_operator(operator.eq, lambda b, x, y: b.fcmp_ordered("==", x, y), mask_type)


def _define_mask_operator(symbol, emit):
    @intrinsic
    def apply(_context, a, b):
        return mask_type(a, b), lambda _context, builder, _signature, pair: emit(builder, *pair)

    @overload(symbol)
    def _on_masks(a, b):
        if a == mask_type and b == mask_type:
            return lambda a, b: apply(a, b)
        return None


_define_mask_operator(operator.and_, ir.IRBuilder.and_)
_define_mask_operator(operator.or_, ir.IRBuilder.or_)


def _pointer(context, builder, array_type, array, row, start):
    """Address of eight doubles of a C-contiguous 2D array."""
    struct = context.make_array(array_type)(context, builder, array)
    columns = cgutils.unpack_tuple(builder, struct.shape)[1]
    address = builder.gep(struct.data, [builder.add(builder.mul(row, columns), start)])
    return builder.bitcast(address, _DOUBLES.as_pointer())


@intrinsic
def load(_context, array, row, start):
    """Read array[row, start : start + 8]; the caller has checked the bounds."""

    def generate(context, builder, signature, arguments):
        value = builder.load(_pointer(context, builder, signature.args[0], *arguments))
        value.align = _DOUBLE_BYTES
        return value

    return lanes_type(array, types.int64, types.int64), generate


@intrinsic
def store(_context, array, row, start, value):
    """Set array[row, start : start + 8]; the caller has checked the bounds."""

    def generate(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], *arguments[:3])
        builder.store(arguments[3], pointer).align = _DOUBLE_BYTES
        return context.get_dummy_value()

    return types.none(array, types.int64, types.int64, lanes_type), generate


@intrinsic
def store_numbers(_context, array, start, value):
    """Set array[start : start + 8] of int32 to whole numbers; the caller has checked the bounds."""

    def generate(context, builder, signature, arguments):
        array, start, value = arguments
        data = context.make_array(signature.args[0])(context, builder, array).data
        pointer = builder.bitcast(builder.gep(data, [start]), _NUMBERS.as_pointer())
        builder.store(builder.fptosi(value, _NUMBERS), pointer).align = _NUMBER_BYTES
        return context.get_dummy_value()

    return types.none(array, types.int64, lanes_type), generate


@intrinsic
def everywhere(_context, number):
    """Put the same number into every lane."""
    return lanes_type(types.float64), lambda _context, builder, signature, arguments: _broadcast(
        builder, signature.args[0], arguments[0]
    )


@intrinsic
def lane_numbers(_context):
    """Return 0, 1, ... 7."""
    numbers = ir.Constant(_DOUBLES, [float(lane) for lane in range(WIDTH)])
    return lanes_type(), lambda _context, _builder, _signature, _arguments: numbers


@intrinsic
def multiply_add(_context, a, b, c):
    """Return a b + c, rounded once where the processor can."""

    def generate(_context, builder, signature, arguments):
        pairs = zip(signature.args, arguments, strict=True)
        values = [_broadcast(builder, kind, value) for kind, value in pairs]
        return _call(builder, "llvm.fmuladd.v8f64", _DOUBLES, values)

    return lanes_type(a, b, c), generate


@intrinsic
def square_root(_context, a):
    """Take the square root of each lane."""
    return lanes_type(lanes_type), lambda _context, builder, _signature, arguments: _call(
        builder, "llvm.sqrt.v8f64", _DOUBLES, arguments
    )


@intrinsic
def absolute(_context, a):
    """Take the absolute value of each lane."""
    return lanes_type(lanes_type), lambda _context, builder, _signature, arguments: _call(
        builder, "llvm.fabs.v8f64", _DOUBLES, arguments
    )


@intrinsic
def select(_context, mask, a, b):
    """Take lanes of a where the mask is set, of b elsewhere."""

    def generate(_context, builder, signature, arguments):
        yes = _broadcast(builder, signature.args[1], arguments[1])
        no = _broadcast(builder, signature.args[2], arguments[2])
        return builder.select(arguments[0], yes, no)

    return lanes_type(mask_type, a, b), generate


@intrinsic
def compress(_context, value, mask):
    """Move lanes whose mask is set to the front, in order; the others are arbitrary."""

    def generate(_context, builder, _signature, arguments):
        arguments = [*arguments, ir.Constant(_DOUBLES, ir.Undefined)]
        return _call(builder, "llvm.experimental.vector.compress.v8f64", _DOUBLES, arguments)

    return lanes_type(lanes_type, mask_type), generate


@intrinsic
def bits(_context, mask):
    """Turn a mask into a number: bit k is lane k."""

    def generate(_context, builder, _signature, arguments):
        return builder.zext(builder.bitcast(arguments[0], _BYTE), ir.IntType(64))

    return types.int64(mask_type), generate


@intrinsic
def mask_of(_context, number):
    """Turn the lowest eight bits of a number into a mask."""

    def generate(_context, builder, _signature, arguments):
        return builder.bitcast(builder.trunc(arguments[0], _BYTE), _FLAGS)

    return mask_type(types.int64), generate


@intrinsic
def count_bits(_context, number):
    """Count the bits of a number that are set."""
    return types.int64(types.int64), lambda _context, builder, _signature, arguments: builder.ctpop(
        arguments[0]
    )


@intrinsic
def lowest_bit(_context, number):
    """Find the lowest bit that is set in a number other than 0."""
    return types.int64(types.int64), lambda _context, builder, _signature, arguments: builder.cttz(
        arguments[0], ir.IntType(1)(1)
    )


def _define_reduction(name):
    @intrinsic
    def reduce(_context, a):
        def generate(_context, builder, _signature, arguments):
            # Without NaN in play a tree of plain minima or maxima will do.
            full_name = f"llvm.vector.reduce.{name}.v8f64"
            return _call(builder, full_name, ir.DoubleType(), arguments, fastmath=("nnan",))

        return types.float64(lanes_type), generate

    return reduce


#: Least and largest of the eight numbers, none of them NaN.
least = _define_reduction("fmin")
largest = _define_reduction("fmax")


@intrinsic
def transpose(_context, a, b, c, d, e, f, g, h):
    """Turn eight registers, the rows of a matrix, into its eight columns."""
    result = types.UniTuple(lanes_type, WIDTH)

    def generate(context, builder, _signature, arguments):
        rows = list(arguments)
        for step in (1, 2, 4):  # swap the off-diagonal halves of blocks of 2, 4 and 8
            for i in range(WIDTH):
                if i & step:
                    continue
                upper, lower = rows[i], rows[i | step]
                for place, offset in ((i, 0), (i | step, step)):
                    chosen = [
                        WIDTH + k - step + offset if k & step else k + offset for k in range(WIDTH)
                    ]
                    mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), chosen)
                    rows[place] = builder.shuffle_vector(upper, lower, mask)
        return context.make_tuple(builder, result, rows)

    return result(a, b, c, d, e, f, g, h), generate


@inner
def store_transposed(array, row, start, a, b, c, d, e, f, g, h):
    """Store eight registers as columns: lane k of each goes to row + k."""
    rows = transpose(a, b, c, d, e, f, g, h)
    store(array, row, start, rows[0])
    store(array, row + 1, start, rows[1])
    store(array, row + 2, start, rows[2])
    store(array, row + 3, start, rows[3])
    store(array, row + 4, start, rows[4])
    store(array, row + 5, start, rows[5])
    store(array, row + 6, start, rows[6])
    store(array, row + 7, start, rows[7])


@inner
def load_transposed(array, row, start):
    """Read eight columns of eight rows as eight registers."""
    return transpose(
        load(array, row, start),
        load(array, row + 1, start),
        load(array, row + 2, start),
        load(array, row + 3, start),
        load(array, row + 4, start),
        load(array, row + 5, start),
        load(array, row + 6, start),
        load(array, row + 7, start),
    )
