# SPDX-License-Identifier: GPL-3.0-or-later
"""Many runs of one scene: over records, intensities, materials and seeds, on the cores of this machine or of a cluster.

    study_file    the study file and its tables            varied     lists, ranges and distributions of what varies
    records       motions found in a folder, their measures designs    which runs there are
    plan          a run as asked becomes a scene           task       a run, as a worker makes it
    engine        runs as futures, results as they arrive    clusters   where they run
    folder        what is kept of a study, to continue it  table      runs.csv and runs.parquet
    progress      how far it is                            study_case makes the runs of a plan, whichever
    command       masonry-cd study

A run is a pure function of its scene, and its name a digest of that scene. So a study goes on where it was left, more records or levels
add only their own runs, and the table is the same for any number of workers.
"""
