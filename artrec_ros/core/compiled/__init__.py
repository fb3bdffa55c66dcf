"""Both stages' inner loops, compiled by numba and cached on disk after their first run.

Where only the best of many counts, they leave out what cannot change the answer. With NUMBA_DISABLE_JIT=1 in the
environment they run as plain Python.
"""
