"""What each vertex of the normal flow remembers: what it does, and what wakes it."""

# mypy: allow-untyped-defs, allow-untyped-calls

from shapery_segmentation.mesh.arrays import CREATED, OUT, RELINKED, TOUCHED, UNTOUCHED, VERTEX_TOP
from shapery_segmentation.mesh.compiled import inner, kernel

# Columns of the vertices' state (float64).
NET = 0  # way along the normal since the window began, mm
GAIN = 1  # share of the full step; falls with every change of direction
STEP = 2  # way along the normal of the last step, mm
LAST = 3  # previous position (3)
SEEN = 6  # position from which obstacles were last looked for (3)
FREE = 9  # how far from there it may move until they are looked for again, mm
STATE_COLUMNS = 10

# Columns of the vertices' counters (int32).
MODE = 0
FLIPS = 1  # changes of direction in a row
SIGN = 2  # direction of the last step
AGE = 3  # steps since the window began
BLOCKED = 4  # steps in a row that an obstacle forbade
WISH = 5  # what would help a blocked vertex
RETURNS = 6  # verifications in a row that put it back
COUNTER_COLUMNS = 7

# Values of MODE.
AWAKE = 0
ASLEEP = 1
AGED = 2
FROZEN = 3

# Values of WISH.
NONE = 0
REFINE = 1
COLLAPSE = 2
MEET = 3

OSCILLATING = 2
"""Changes of direction in a row from which a vertex counts as oscillating."""


@inner
def wake(state, counter, v):
    """Set a vertex at rest going again, unless it was stopped for its age."""
    if counter[v, MODE] == ASLEEP or counter[v, MODE] == FROZEN:
        counter[v, MODE] = AWAKE
        counter[v, AGE] = 0
        counter[v, BLOCKED] = 0
        state[v, NET] = 0.0


@kernel
def wake_all(m, state, counter):
    """Wake every vertex, those stopped for their age too: what they rested on has changed."""
    for v in range(m.layout[VERTEX_TOP]):
        if m.vertices[v, OUT] >= 0:
            wake(state, counter, v)
            counter[v, MODE] = AWAKE
            counter[v, FLIPS] = 0
            counter[v, SIGN] = 0
            state[v, GAIN] = 1.0


@kernel
def adopt_touched(m, state, counter, clear):
    """Begin anew at vertices that an operation created, wake those whose neighbours it changed; forget its marks."""
    for v in range(m.layout[VERTEX_TOP]):
        mark = m.vertices[v, TOUCHED]
        if mark == UNTOUCHED:
            continue
        m.vertices[v, TOUCHED] = UNTOUCHED
        if m.vertices[v, OUT] < 0:
            continue
        if mark == CREATED:
            for column in range(STATE_COLUMNS):
                state[v, column] = 0.0
            for column in range(COUNTER_COLUMNS):
                counter[v, column] = 0
            state[v, GAIN] = 1.0
            clear[v] = 0
        elif mark == RELINKED:
            wake(state, counter, v)
