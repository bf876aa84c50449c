"""Models of city streets as uDALES has them: triangles whose corners are counter-clockwise as seen from the air."""


def rectangle(a, b, c, d):
    """Two triangles; corners are counter-clockwise as seen from the air."""
    return [(a, b, c), (a, c, d)]


# Heights of a court with two houses. What surrounds it is highest, so that no wall sees past the model:
# uDALES has no place for light that leaves downwards.
HEIGHTS = [
    [15, 15, 15, 15, 15],
    [15, 0, 0, 0, 15],
    [15, 0, 6, 12, 15],
    [15, 0, 0, 0, 15],
    [15, 15, 15, 15, 15],
]
SIDE = 8.0


def street():
    """Ground, roofs, and walls where heights differ, in triangles."""
    facets = []
    for k, row in enumerate(HEIGHTS):
        for i, height in enumerate(row):
            x, y = i * SIDE, k * SIDE
            low, high = [(x, y), (x + SIDE, y)], [(x + SIDE, y + SIDE), (x, y + SIDE)]
            facets += rectangle(*((*p, float(height)) for p in low + high))
            if i + 1 < len(row):
                facets += wall((x + SIDE, y), (x + SIDE, y + SIDE), height, row[i + 1])
            if k + 1 < len(HEIGHTS):
                facets += wall((x + SIDE, y + SIDE), (x, y + SIDE), height, HEIGHTS[k + 1][i])
    return facets


def wall(p, q, height, other):
    """Between a place and the one to the right of it, as seen along from p to q."""
    if height < other:
        p, q = q, p
    low, high = sorted([float(height), float(other)])
    return rectangle((*p, low), (*q, low), (*q, high), (*p, high)) if low < high else []


# The wall stands 10 m from the edge of the ground, and sees past it.
GROUND = rectangle((0, 0, 0), (30, 0, 0), (30, 30, 0), (0, 30, 0))
BLOCK = GROUND + rectangle((20, 0, 0), (20, 30, 0), (20, 30, 10), (20, 0, 10))
