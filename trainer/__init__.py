"""Learning: from a ranking to a reward model, an imitator and a clone. Knows no web."""

import os

# Threads of OpenMP that wait for each other spin by default. Beside anything else on the cores (the
# emulators, a person who plays) two spinning threads are three to six times slower than two that
# sleep; with the cores to themselves they are as fast. It has to be set before torch is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

# Figures are drawn into files. What is set for other programs may not exist here, and matplotlib
# then can't be imported.
os.environ["MPLBACKEND"] = "agg"
