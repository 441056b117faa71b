"""How functions that only kernels call are compiled: not at all on their own.

numba compiles every function by itself, optimises it, turns it into machine code and wraps it for
Python and for C, before it does all that again with what calls it. Here a function is only
translated; what calls it takes the translation in, and is optimised as a whole. That saves a third
of the time that a first run compiles.

Their arguments, and those of kernels, are borrowed: who calls holds them until the call returns, so
that nobody needs to count that they are used. numba counts, whenever it passes an array on, in
memory that all threads share: a tenth of the filter's time.
"""

from numba.core import ir
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, _LowerResult
from numba.core.compiler_machinery import FunctionPass, LoweringPass, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering, NativeLowering
from numba.core.untyped_passes import IRProcessing


class _Translation(JITCodeLibrary):
    """A function's translation, and those of what it calls, neither optimised nor loaded."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=False)
class _BeginTranslation(FunctionPass):
    _name = "begin_translation"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        codegen = state.targetctx.codegen()
        state.library = _Translation(codegen, state.func_id.func_qualname)
        state.flags.no_compile = True
        return False


@register_pass(mutates_CFG=False, analysis_only=False)
class _EndTranslation(LoweringPass):
    _name = "end_translation"

    def __init__(self):
        LoweringPass.__init__(self)

    def run_pass(self, state):
        result = state["cr"]
        # numba knows a function by its entry for Python. There is none, but there must be something
        # that is callable, and this function's alone.
        entry = [].clear
        state.library.finalize()
        state.targetctx.insert_user_function(entry, result.fndesc, [state.library])
        state["cr"] = _LowerResult(result.fndesc, result.call_helper, cfunc=entry, env=result.env)
        return True


class _BorrowingLower(Lower):
    """Does not count references to arguments, unless a name gets another value, too."""

    _is_argument = False

    def lower_normal_function(self, fndesc):
        assigned = {}
        for block in self.blocks.values():
            for inst in block.find_insts(ir.Assign):
                assigned.setdefault(inst.target.name, []).append(inst.value)
        self._borrowed = {
            name
            for name, values in assigned.items()
            if len(values) == 1 and isinstance(values[0], ir.Arg)
        }
        super().lower_normal_function(fndesc)

    def lower_assign(self, ty, inst):
        self._is_argument = inst.target.name in self._borrowed
        try:
            return super().lower_assign(ty, inst)
        finally:
            self._is_argument = False

    def incref(self, typ, val):
        if not self._is_argument:
            super().incref(typ, val)

    def delvar(self, name):
        if name not in self._borrowed:
            super().delvar(name)


@register_pass(mutates_CFG=True, analysis_only=False)
class _BorrowingLowering(BaseNativeLowering):
    _name = "borrowing_lowering"

    @property
    def lowering_class(self):
        return _BorrowingLower


class KernelCompiler(CompilerBase):
    """numba's own way, but that arguments are borrowed."""

    def define_pipelines(self):
        """Put the other translation in the place of numba's."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_BorrowingLowering, NativeLowering)
        passes.passes = [each for each in passes.passes if each[0] is not NativeLowering]
        passes.finalize()
        return [passes]


class InnerCompiler(CompilerBase):
    """The same, but that it ends before anything is optimised."""

    def define_pipelines(self):
        """Add to the passes what puts the translation in the place of the finished code."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_BeginTranslation, IRProcessing)
        passes.add_pass_after(_BorrowingLowering, NativeLowering)
        passes.add_pass_after(_EndTranslation, _BorrowingLowering)
        passes.passes = [each for each in passes.passes if each[0] is not NativeLowering]
        passes.finalize()
        return [passes]
