"""Compiled twins of both stages' inner loops, used where numba is installed and cached on disk after
their first run.

The numpy code beside each caller says what is computed; a twin says the same a hypothesis and a point at a
time, and leaves out what cannot change the answer. Sums are taken in another order: results agree to rounding.
"""
