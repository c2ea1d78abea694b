# SPDX-License-Identifier: GPL-3.0-or-later
"""Malformed and damaged inputs: does the program refuse them as it promises?

    .venv/bin/python -m benchmarks.fuzz --minutes 10 --seed 1

Good inputs of every kind (:mod:`benchmarks.fuzz.inputs`) are changed at random (:mod:`benchmarks.fuzz.mutators`) and given to the command
line, each in a process of its own with limits of time and memory (:mod:`benchmarks.fuzz.worker`), or many in one
(``--together 100``, :mod:`benchmarks.fuzz.together`). What breaks a promise
(:mod:`benchmarks.fuzz.promises`) is kept in a folder with its files and the command that repeats it. Case N of a seed is always the same.
"""

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy comes: a process with threads must not fork
