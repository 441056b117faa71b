"""The experiments of the thesis, done again: numbers, pictures, and whether they agree.

A package beside pcsmooth, which runs without it: `pcsmooth experiments` alone needs it.
"""
