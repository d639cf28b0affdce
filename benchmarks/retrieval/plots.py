"""Figs 4.8 and 4.9, drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

mpl.use("Agg")
from matplotlib import pyplot as plt

Array = NDArray[np.float64]


def draw_class_matrix(matrix: Array, names: Sequence[str], path: Path) -> None:
    """Fig. 4.8: darker squares stand for higher mean scores between two classes, told in hundredths."""
    figure, axes = plt.subplots(figsize=(8, 7.2), layout="constrained")
    image = axes.imshow(matrix, cmap="Greys", vmin=0)
    axes.set_xticks(range(len(names)), names, rotation=90)
    axes.set_yticks(range(len(names)), names)
    axes.set_title("Mean score of a class (row) with another (column), in hundredths", fontsize=11)
    for (row, column), score in np.ndenumerate(matrix):
        if score >= 0.05:
            shade = "white" if score > 0.55 * matrix.max() else "black"
            axes.text(column, row, f"{100 * score:.0f}", ha="center", va="center", fontsize=7, color=shade)
    figure.colorbar(image, shrink=0.7, label="score")
    figure.savefig(path, dpi=120)
    plt.close(figure)


def draw_precision_recall(
    curves: Mapping[str, tuple[Array, Array]], path: Path, *, others: Sequence[str], relevant: int
) -> None:
    """Fig. 4.9: precision and recall against the number of shapes retrieved, and against each other.

    Parameters
    ----------
    curves
        Precision and recall by method.
    path
        Of the picture.
    others
        Methods that stand beside ours, drawn thin.
    relevant
        How many shapes there are to be found, where precision equals recall.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.8), layout="constrained")
    thin = dict(zip(others, ("#9a9a9a", "#c0a16b", "#7fa88b", "#b48ead"), strict=True))
    bold = iter(("#4477aa", "#66ccee", "#228833", "#ee7733", "#cc3311"))
    for name, (precision, recall) in curves.items():
        colour, width = (thin[name], 1.1) if name in thin else (next(bold), 2.0)
        shown = min(100, len(precision))
        left.plot(np.arange(1, shown + 1), precision[:shown], color=colour, linewidth=width)
        left.plot(np.arange(1, shown + 1), recall[:shown], color=colour, linewidth=width, linestyle=(0, (4, 2)))
        right.plot(recall, precision, color=colour, linewidth=width, label=name)
    left.axvline(relevant, color="black", linewidth=0.8, alpha=0.5)
    left.annotate(f"{relevant} of a class", (relevant, 0.02), (3, 0), textcoords="offset points", fontsize=8)
    left.set(xlabel="shapes retrieved", ylabel="precision (line), recall (dashed)", xlim=(0, 100), ylim=(0, 1.02))
    right.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02))
    figure.legend(*right.get_legend_handles_labels(), fontsize=9, loc="outside right center", frameon=False)
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=120)
    plt.close(figure)
