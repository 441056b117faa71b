"""The level of processors that kernels are compiled for.

For the very processor they would run a little faster at most, but only there: what is compiled for
a level runs on every processor of that level, and gives the same bytes on all of them.
"""

import numba
from llvmlite import binding
from numba.core.registry import cpu_target

#: Levels of the x86-64 ABI from the lowest on, and what each has that the one before it lacks: by
#: LLVM's names.
_BASE = "x86-64"
_LEVELS = {
    "x86-64-v2": {"cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"},
    "x86-64-v3": {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"},
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
}


def processor_level() -> str:
    """Find the highest level that this processor reaches, by LLVM's name."""
    if not binding.get_process_triple().startswith("x86_64"):
        return "generic"  # on Arm that has NEON
    features = binding.get_host_cpu_features()
    reached = _BASE
    for level, needed in _LEVELS.items():
        if not all(features.get(name, False) for name in needed):
            break
        reached = level
    return reached


def _up_to(reached: str) -> list[str]:
    """List the levels of x86-64 that a processor which reaches one can run."""
    levels = [_BASE, *_LEVELS]
    return levels[: levels.index(reached) + 1] if reached in levels else []


def _compile_for_level() -> str:
    """Have kernels compiled for a level; says for which, or for which processor.

    NUMBA_CPU_NAME is heeded, but for levels that this processor does not reach. If something has
    been compiled in this process before, that is for this very processor, and so are the kernels.
    """
    config = numba.config
    reached = processor_level()
    levels = [_BASE, *_LEVELS]
    is_free = config.CPU_NAME is None and "_toplevel_target_context" not in vars(cpu_target)
    if is_free or (config.CPU_NAME in levels and config.CPU_NAME not in _up_to(reached)):
        config.CPU_NAME = reached
    if config.CPU_NAME in {"generic", *levels} and config.CPU_FEATURES is None:
        config.CPU_FEATURES = ""  # no more than the level has
    return str(config.CPU_NAME or binding.get_host_cpu_name())


#: What kernels are compiled for.
COMPILED_FOR = _compile_for_level()
