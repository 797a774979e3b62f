# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Open3D's ways from views in their places to a surface, on the same meshes and poses.

Its volume takes depth images of a pinhole only. Every view's mesh is therefore drawn into one, two
pixels a dres: at the sensor for a pinhole; for parallel rays from so far away that they differ
by a degree and a half at most. Drawing is not timed.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from ros_rops.bench.model_run import Maker, ModelJob, Posed
from ros_rops.core.se3 import move
from ros_rops.core.types import Floats
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.recordings.raycast import Camera, cast
from scipy.spatial import cKDTree

AWAY = 20.0
"""Distance of the eye for parallel rays, in radii of the view."""
PIXELS_A_DRES = 2.0
MOST_PIXELS = 1400
TRUNCATION = 4.0
"""In voxels, both for the volume here and for ours by default."""
TRIM_DRES = 2.0
BALLS_DRES = (1.0, 2.0, 4.0)


@dataclass(frozen=True, slots=True)
class DepthImage:
    """A view as Open3D's volume takes it: depth (H, W) float32, 0 where nothing is."""

    depth: Any
    camera: Camera
    T_camera_world: Floats


def drawn(posed: PosedView, dres: float) -> DepthImage:
    """Draw a view's mesh into a depth image of a pinhole."""
    sensor, vertices = posed.view.sensor, posed.mesh.vertices
    used = vertices[np.unique(posed.mesh.faces)]
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    radius = float(np.linalg.norm(used - middle, axis=1).max())
    eye = np.asarray(sensor.origin) if sensor.kind == 'pinhole' \
        else middle - AWAY * radius * np.asarray(sensor.direction)
    forward = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(np.eye(3)[np.argmin(np.abs(forward))], forward)
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, :3] = np.stack([right, np.cross(forward, right), forward])
    T[:3, 3] = -T[:3, :3] @ eye
    local = move(T, vertices)
    camera = _camera(local[np.unique(posed.mesh.faces)], dres)
    depth, _ = cast(local, posed.mesh.faces, camera)
    T_camera_world = T @ np.linalg.inv(posed.T_object_view)
    return DepthImage(np.nan_to_num(depth).astype(np.float32), camera, T_camera_world)


def _camera(local: Floats, dres: float) -> Camera:
    image = local[:, :2] / local[:, 2:]
    low, size = image.min(axis=0), np.ptp(image, axis=0)
    focal = PIXELS_A_DRES * float(np.median(local[:, 2])) / dres
    focal *= min(1.0, MOST_PIXELS / (focal * float(size.max())))
    width, height = (np.ceil(size * focal) + 5).astype(int)
    cx, cy = 2 - low * focal
    return Camera(int(width), int(height), focal, focal, float(cx), float(cy))


def draw_all(job: ModelJob) -> list[DepthImage]:
    """Draw all views."""
    return [drawn(view, job.dres) for view in job.posed()]


def fuse(job: ModelJob, images: list[DepthImage]) -> SurfaceMesh:
    """Integrate depth images into Open3D's `ScalableTSDFVolume` and extract its triangles."""
    import open3d as o3d

    voxel = job.config.model.voxel_mr * job.dres
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=voxel, sdf_trunc=TRUNCATION * voxel,
        color_type=o3d.pipelines.integration.TSDFVolumeColorType.NoColor)
    for image in images:
        height, width = image.depth.shape
        rgbd = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(np.zeros((height, width, 3), np.uint8)),
            o3d.geometry.Image(image.depth), depth_scale=1.0, depth_trunc=1e9,
            convert_rgb_to_intensity=False)
        camera = image.camera
        volume.integrate(rgbd, o3d.camera.PinholeCameraIntrinsic(
            width, height, camera.fx, camera.fy, camera.cx, camera.cy), image.T_camera_world)
    return surface_of(volume.extract_triangle_mesh())


def surface_of(mesh: Any) -> SurfaceMesh:
    """Return an Open3D mesh as ours."""
    mesh.compute_vertex_normals()
    faces = np.asarray(mesh.triangles, dtype=np.int32)
    return SurfaceMesh(
        np.array(mesh.vertices), faces, np.asarray(mesh.vertex_normals, np.float32), None,
        np.zeros(len(faces), bool))


def joined(job: ModelJob) -> tuple[Floats, Floats]:
    """Return all points that have a face, with their normals, in the world, (N, 3) each."""
    posed: Posed = job.posed()
    keep = [view.mesh.normals.any(axis=1) for view in posed]
    return (
        np.concatenate([view.points[k] for view, k in zip(posed, keep, strict=True)]),
        np.concatenate([view.normals[k] for view, k in zip(posed, keep, strict=True)]))


def _cloud(points: Floats, normals: Floats) -> Any:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.normals = o3d.utility.Vector3dVector(normals)
    return cloud


def solve(job: ModelJob, cloud: tuple[Floats, Floats]) -> SurfaceMesh:
    """Make Open3D's screened Poisson surface, cells of about a voxel."""
    import open3d as o3d

    voxel = job.config.model.voxel_mr * job.dres
    extent = 1.1 * float(np.ptp(cloud[0], axis=0).max())
    depth = int(np.ceil(np.log2(extent / voxel)))
    mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(
        _cloud(*cloud), depth=depth, n_threads=job.threads or -1)
    return surface_of(mesh)


def solve_trimmed(job: ModelJob, cloud: tuple[Floats, Floats]) -> SurfaceMesh:
    """Return the Poisson surface without the vertices that no point is within 2 dres of."""
    whole = solve(job, cloud)
    away, _ = cKDTree(cloud[0]).query(
        whole.vertices, distance_upper_bound=TRIM_DRES * job.dres)
    kept = np.isfinite(away)[whole.faces].all(axis=1)
    return SurfaceMesh(
        whole.vertices, whole.faces[kept], whole.normals, None, whole.filled[kept])


def roll(job: ModelJob, cloud: tuple[Floats, Floats]) -> SurfaceMesh:
    """Roll balls over the points, thinned to a voxel."""
    import open3d as o3d

    voxel = job.config.model.voxel_mr * job.dres
    points = _cloud(*cloud).voxel_down_sample(voxel)
    points.normalize_normals()
    return surface_of(o3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(
        points, o3d.utility.DoubleVector([ball * voxel for ball in BALLS_DRES])))


PEERS = {
    'open3d tsdf': Maker('open3d tsdf', draw_all, fuse),
    'open3d poisson': Maker('open3d poisson', joined, solve),
    'open3d poisson trimmed': Maker('open3d poisson trimmed', joined, solve_trimmed),
    'open3d ball pivoting': Maker('open3d ball pivoting', joined, roll),
}
