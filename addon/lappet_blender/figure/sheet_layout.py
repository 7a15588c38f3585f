"""Where the panels of a contact sheet go."""

from __future__ import annotations


def columns_for(count: int) -> int:
    """Panels a row: 1, 2, 3, 2, 3, 3 for one to six panels."""
    return {1: 1, 2: 2, 3: 3, 4: 2}.get(count, 3)


def sheet_layout(count: int, panel: tuple[int, int]) -> tuple[tuple[int, int], list[tuple[int, int]], int]:
    """Size of the sheet, the top left corner of every panel, and the height of a caption, all in pixels.

    count: number of panels, at least 1. panel: width and height of one.
    """
    columns = columns_for(count)
    rows = -(-count // columns)
    gap, edge, caption = round(panel[0] * 0.045), round(panel[0] * 0.07), round(panel[0] * 0.155)
    width = 2 * edge + columns * panel[0] + (columns - 1) * gap
    height = 2 * edge + rows * (panel[1] + caption) + (rows - 1) * round(gap * 0.6)
    corners = []
    for k in range(count):
        row, column = divmod(k, columns)
        short = columns - min(columns, count - row * columns)
        x = edge + column * (panel[0] + gap) + short * (panel[0] + gap) // 2
        corners.append((x, edge + row * (panel[1] + caption + round(gap * 0.6))))
    return (width, height), corners, caption
