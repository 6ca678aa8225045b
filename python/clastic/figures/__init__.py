"""Figures for papers, by matplotlib: one function each, which returns the axes that it has drawn.

Every function draws into ``ax`` or, without it, into a new figure as wide as a column of a journal
(:data:`WIDTH`). What the axes show is yours to change: labels, limits, colours, further curves.
Save them by ``ax.figure.savefig("figure.pdf")``; use :func:`style` around figures of your own for
the same letters and lines.

===================  ==========================================================================
of the history       ``stress_strain``, ``volumetric``, ``force_displacement``, ``energies``,
                     ``fabric``, ``mohr``
of the specimen      ``specimen``, ``bonds``, ``force_chains``, ``stress``, ``fragments``,
                     ``layers``, ``rotation``, ``displacement``, ``shear_strain``,
                     ``volumetric_strain``, ``localisation``
of the emission      ``emission_sizes``, ``b_value``, ``emission_cycles``, ``foci``
of a slope           ``slide``
of directions        ``crack_rose``, ``contact_rose``, ``force_rose``
===================  ==========================================================================

Figures of the history take runs, those of the specimen a run with a moment (``at``), or a frame.
"""

from .curves import energies, fabric, force_displacement, mohr, stress_strain, volumetric
from .emission import b_value, emission_cycles, emission_sizes
from .roses import contact_rose, crack_rose, force_rose
from .slopes import slide
from .specimen import (
    bonds,
    displacement,
    foci,
    force_chains,
    fragments,
    layers,
    localisation,
    rotation,
    shear_strain,
    specimen,
    stress,
    volumetric_strain,
)
from .style import WIDTH, close, style

__all__ = [
    "WIDTH",
    "b_value",
    "bonds",
    "close",
    "contact_rose",
    "crack_rose",
    "displacement",
    "emission_cycles",
    "emission_sizes",
    "energies",
    "fabric",
    "foci",
    "force_chains",
    "force_displacement",
    "force_rose",
    "fragments",
    "layers",
    "localisation",
    "mohr",
    "rotation",
    "shear_strain",
    "slide",
    "specimen",
    "stress",
    "stress_strain",
    "style",
    "volumetric",
    "volumetric_strain",
]
