# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A window to turn an object in: Open3D's, or where that is not installed matplotlib's."""

import importlib.util

import numpy as np
from ros_rops.reporting.shown import Shown

MOST_DRAWN = 20_000
"""Points or faces in a window of matplotlib, which draws all of them anew when it is turned."""


def show(shown: Shown, title: str) -> bool:
    """Show a window until it is closed; tell whether one could be opened."""
    if importlib.util.find_spec('open3d') is not None:
        return _open3d(shown, title)
    return _matplotlib(shown, title)


def _open3d(shown: Shown, title: str) -> bool:
    import open3d

    # It would print what it tried; the caller says what came of it.
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        window = open3d.visualization.Visualizer()
        if not window.create_window(title):
            return False
        vector = open3d.utility.Vector3dVector
        if shown.faces is None:
            drawn = open3d.geometry.PointCloud(vector(shown.points))
            drawn.colors = vector(shown.colors / 255.0)
        else:
            drawn = open3d.geometry.TriangleMesh(
                vector(shown.points), open3d.utility.Vector3iVector(shown.faces))
            drawn.vertex_normals = vector(shown.normals)
            drawn.vertex_colors = vector(shown.colors / 255.0)
        window.get_render_option().mesh_show_back_face = True
        window.add_geometry(drawn)
        window.run()
        window.destroy_window()
    return True


def _matplotlib(shown: Shown, title: str) -> bool:
    import matplotlib

    try:
        from matplotlib import pyplot

        figure = pyplot.figure(title)
        if matplotlib.get_backend().lower() == 'agg':
            return False  # it found nothing to open a window with
    except ImportError:
        return False
    axes = figure.add_subplot(projection='3d')
    pick = np.arange(0, len(shown.points), max(1, len(shown.points) // MOST_DRAWN))
    axes.scatter(*shown.points[pick].T, c=shown.colors[pick] / 255.0, s=4.0, depthshade=False)
    axes.set_box_aspect(np.ptp(shown.points, axis=0))
    axes.set_axis_off()
    pyplot.show()
    return True
