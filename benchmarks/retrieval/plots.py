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
    """Fig. 4.8: darker squares stand for higher mean scores between two classes."""
    figure, axes = plt.subplots(figsize=(7, 6.4), layout="constrained")
    image = axes.imshow(matrix, cmap="Greys", vmin=0)
    axes.set_xticks(range(len(names)), names, rotation=90)
    axes.set_yticks(range(len(names)), names)
    axes.set_title("Mean matching score between classes")
    figure.colorbar(image, shrink=0.8)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def draw_precision_recall(curves: Mapping[str, tuple[Array, Array]], path: Path) -> None:
    """Fig. 4.9: precision and recall against the number of shapes retrieved, and against each other."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.6), layout="constrained")
    for index, (name, (precision, recall)) in enumerate(curves.items()):
        colour = f"C{index % 10}"
        shown = min(100, len(precision))
        left.plot(np.arange(1, shown + 1), precision[:shown], color=colour, label=name)
        left.plot(np.arange(1, shown + 1), recall[:shown], color=colour, linestyle="--")
        right.plot(recall, precision, color=colour, label=name)
    left.set(xlabel="shapes retrieved", ylabel="precision (line), recall (dashed)", ylim=(0, 1.02))
    right.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02))
    figure.legend(*right.get_legend_handles_labels(), fontsize=8, loc="outside right center")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=120)
    plt.close(figure)
