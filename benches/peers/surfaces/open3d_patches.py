#!/usr/bin/env python3
"""Open3D's planar patches of depth frames, one thread, as files for score.py.

    open3d_patches.py FRAMES RESULTS [RUNS]
"""
import glob
import json
import os
import sys
import time

import numpy as np
import open3d

LEAF_M, RANGE_M = 0.016, 5.0


def patches(points):
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud = cloud.voxel_down_sample(LEAF_M)
    neighbours = open3d.geometry.KDTreeSearchParamKNN(30)
    cloud.estimate_normals(neighbours)
    return cloud, cloud.detect_planar_patches(search_param=neighbours)


def main():
    frames, results = sys.argv[1:3]
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    os.makedirs(results, exist_ok=True)
    for path in sorted(glob.glob(frames + "/*_gt.json")):
        name = os.path.basename(path)[: -len("_gt.json")]
        raw = open(os.path.join(frames, name + ".pcd"), "rb").read()
        start = raw.index(b"DATA binary\n") + len(b"DATA binary\n")
        points = np.frombuffer(raw, "<f4", offset=start).reshape(-1, 3).astype(float)
        points = points[np.isfinite(points[:, 2]) & ((points**2).sum(1) <= RANGE_M**2)]
        times = []
        for _ in range(runs):
            begin = time.process_time()
            cloud, boxes = patches(points)
            times.append(1e3 * (time.process_time() - begin))
        thin = np.asarray(cloud.points)
        labels = np.full(len(thin), -1.0)
        apart = np.full(len(thin), np.inf)
        planes = []
        for number, box in enumerate(boxes):
            normal, centre = box.R[:, 2], np.asarray(box.center)
            local = (thin - centre) @ box.R
            half = np.asarray(box.extent) / 2
            # In the patch's rectangle, and nearer to it than to any before it.
            inside = (np.abs(local[:, :2]) <= half[:2]).all(1) & (np.abs(local[:, 2]) < max(half[2], 0.02))
            nearer = inside & (np.abs(local[:, 2]) < apart)
            labels[nearer], apart[nearer] = number, np.abs(local[nearer, 2])
            corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
            corners = [(centre + box.R[:, 0] * a * half[0] + box.R[:, 1] * b * half[1]).tolist() for a, b in corners]
            planes.append({"plane": [*normal.tolist(), float(-normal @ centre)], "polys": [corners]})
        stem = os.path.join(results, name)
        np.hstack([thin, labels[:, None]]).astype(np.float32).tofile(stem + "_pts.bin")
        json.dump(planes, open(stem + ".json", "w"))
        open(stem + "_ms.txt", "w").write(f"{np.median(times):.3f} {min(times):.3f}\n")


if __name__ == "__main__":
    main()
