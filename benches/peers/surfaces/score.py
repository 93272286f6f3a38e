#!/usr/bin/env python3
"""Scores surfaces that were found in depth frames against what stands there.

    score.py FRAMES RESULTS [--detail]

FRAMES holds NAME_gt.json with NAME_gt.bin (as `record --frames` writes them) or NAME_gt.npz (gid, z0).
RESULTS holds a folder a method, in it of every frame
    NAME.json          a list of {"plane": [a, b, c, d], "polys": [[[x, y, z], …], …]}, camera frame
    NAME_labels.bin    of every pixel the index of its plane, uint16, 65535: none; or
    NAME_pts.bin       points with the index of their plane: float32 x y z label
    NAME_ms.txt        milliseconds on one thread: the median of the runs, the least
A plane is found (rec50, rec80) where its pixels and a face's overlap by so much of their union, and
right (prec50) where it is some face's. Faces count from 500 pixels within 5 m on. tops: upward faces
found. RMS: of the found plane from the face's true points. off: area of the polygons that is not on
the face; cover: of what was seen of the face, in the polygons (both of faces found).
"""
import argparse
import glob
import json
import os

import numpy as np

RANGE_M, PIXELS_MIN, PITCH_M = 5.0, 500, 0.01


def frame(stem):
    truth = json.load(open(stem + "_gt.json"))
    raw = open(stem + ".pcd", "rb").read()
    start = raw.index(b"DATA binary\n") + len(b"DATA binary\n")
    points = np.frombuffer(raw, "<f4", offset=start).reshape(480, 640, 3)
    if os.path.exists(stem + "_gt.npz"):
        pixels = np.load(stem + "_gt.npz")
        face, depth = pixels["gid"].astype(int), pixels["z0"].astype(float)
    else:
        raw = open(stem + "_gt.bin", "rb").read()
        count = 480 * 640
        face = np.frombuffer(raw, "<i2", count).astype(int).reshape(480, 640)
        depth = np.frombuffer(raw, "<f4", count, 2 * count).astype(float).reshape(480, 640)
    return truth, points, face, depth


def labels_of(stem, points, near):
    """The plane of every pixel, -1 where there is none."""
    if os.path.exists(stem + "_labels.bin"):
        labels = np.fromfile(stem + "_labels.bin", "<u2").astype(int).reshape(480, 640)
        labels[labels == 65535] = -1
    else:
        from scipy.spatial import cKDTree

        found = np.fromfile(stem + "_pts.bin", np.float32).reshape(-1, 4)
        # Of a thinned cloud the nearest point of it, no farther than one voxel's diagonal.
        apart, nearest = cKDTree(found[:, :3]).query(points[near])
        labels = np.full((480, 640), -1)
        labels[near] = np.where(apart < 0.028, found[nearest, 3].astype(int), -1)
    return np.where(near, labels, -1)


def inside(points, polygon):
    x, y = points[:, 0], points[:, 1]
    result = np.zeros(len(points), bool)
    for (x1, y1), (x2, y2) in zip(polygon, np.roll(polygon, -1, axis=0)):
        crosses = (y1 > y) != (y2 > y)
        if y1 != y2:
            result ^= crosses & (x < (x2 - x1) * (y - y1) / (y2 - y1) + x1)
    return result


def polygons_on(face, truth, polygons, seen_w):
    """Area of the polygons, of that what is off the face (m²), and the part of what was seen in them."""
    normal, origin = np.array(face["normal_w"]), np.array(face["point_w"])
    across = np.cross(normal, [1, 0, 0] if abs(normal[0]) < 0.8 else [0, 1, 0])
    across /= np.linalg.norm(across)
    axes = np.stack([across, np.cross(normal, across)], 1)
    rotation, place = np.array(truth["R_wc"]), np.array(truth["t_wc"])
    flat = [(np.array(p) @ rotation.T + place - origin) @ axes for p in polygons]
    low, high = np.min([p.min(0) for p in flat], 0), np.max([p.max(0) for p in flat], 0)
    grid = np.stack(
        np.meshgrid(*[np.arange(low[k], high[k], PITCH_M) + PITCH_M / 2 for k in (0, 1)]), -1
    ).reshape(-1, 2)
    grid = grid[np.any([inside(grid, p) for p in flat], 0)]
    quads = [(np.array(q) - origin) @ axes for q in face["quads_w"]]
    on = np.any([inside(grid, q) for q in quads], 0) if len(grid) else np.zeros(0, bool)
    # What stands on the face covers it.
    above = origin + grid @ axes.T + normal * 0.005
    for number, box in enumerate(truth["boxes"]):
        if number not in face["boxes"]:
            local = (above - np.array(box["c"])) @ np.array(box["R"])
            on &= ~(np.abs(local) <= np.array(box["h"])).all(1)
    cells = np.unique(np.floor((seen_w - origin) @ axes / PITCH_M), axis=0)
    cells = cells * PITCH_M + PITCH_M / 2
    cover = np.any([inside(cells, p) for p in flat], 0).mean()
    return len(grid) * PITCH_M**2, float((~on).sum()) * PITCH_M**2, float(cover)


def score(truth, points, face, depth, stem):
    near = np.isfinite(points[..., 2]) & ((points**2).sum(-1) <= RANGE_M**2)
    labels = labels_of(stem, points, near)
    planes = json.load(open(stem + ".json"))
    fx, fy, cx, cy = truth["K"]
    v, u = np.mgrid[0:480, 0:640]
    exact = np.stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth], -1)
    rotation, place = np.array(truth["R_wc"]), np.array(truth["t_wc"])
    found = [k for k in range(len(planes)) if (labels == k).sum() >= PIXELS_MIN / 2]
    rows, right = [], set()
    for surface in truth["surfaces"]:
        mine = near & (face == surface["id"])
        if mine.sum() < PIXELS_MIN:
            continue
        best = (0.0, -1)
        for k in found:
            its = labels == k
            both = (mine & its).sum()
            best = max(best, (both / (mine | its).sum(), k)) if both else best
        row = dict(name=surface["name"], iou=best[0], top=surface["normal_w"][2] > 0.9)
        if best[0] >= 0.5:
            right.add(best[1])
            plane = np.array(planes[best[1]]["plane"], float)
            plane /= np.linalg.norm(plane[:3])
            off = exact[mine] @ plane[:3] + plane[3]
            row["rms"] = 1e3 * float(np.sqrt((off**2).mean()))
            polygons = [p for p in planes[best[1]]["polys"] if len(p) > 2]
            if polygons:
                seen = exact[mine] @ rotation.T + place
                row["polygons"] = polygons_on(surface, truth, polygons, seen)
            else:
                row["polygons"] = (0.0, 0.0, 0.0)
        rows.append(row)
    return rows, len(right), len(found)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("frames")
    arguments.add_argument("results")
    arguments.add_argument("--detail", action="store_true")
    options = arguments.parse_args()
    names = sorted(os.path.basename(p)[: -len("_gt.json")] for p in glob.glob(options.frames + "/*_gt.json"))
    frames = {name: frame(os.path.join(options.frames, name)) for name in names}
    kinds = sorted({name.split("_")[0] for name in names})
    methods = sorted(m for m in os.listdir(options.results) if os.path.isdir(os.path.join(options.results, m)))
    times = {}
    for kind in kinds:
        print(f"\n{kind} noise\n")
        print("| | ms med/least | rec50 | prec50 | rec80 | tops | RMS med/p90, mm | off the face | cover |")
        print("|---|---|---|---|---|---|---|---|---|")
        for method in methods:
            rows, right, found, ms = [], 0, 0, []
            for name in (n for n in names if n.startswith(kind + "_")):
                stem = os.path.join(options.results, method, name)
                if not os.path.exists(stem + ".json"):
                    continue
                one, good, all_found = score(*frames[name], stem)
                rows += one
                right, found = right + good, found + all_found
                ms.append([float(t) for t in open(stem + "_ms.txt").read().split()])
                if options.detail:
                    for row in one:
                        print(" ", method, name, row)
            if not rows:
                continue
            part = lambda values: sum(values) / max(1, len(rows))
            tops = [r["iou"] >= 0.5 for r in rows if r["top"]]
            rms = [r["rms"] for r in rows if "rms" in r] or [np.nan]
            polygons = [r["polygons"] for r in rows if r["top"] and "polygons" in r]
            area = sum(p[0] for p in polygons)
            off = 100 * sum(p[1] for p in polygons) / max(area, 1e-9)
            cover = 100 * np.mean([p[2] for p in polygons]) if polygons else 0.0
            times[(kind, method)] = median, least = np.median(ms, 0)
            print(
                f"| {method} | {median:.3g} / {least:.3g} | {part(r['iou'] >= 0.5 for r in rows):.2f}"
                f" | {right / max(1, found):.2f} | {part(r['iou'] >= 0.8 for r in rows):.2f}"
                f" | {np.mean(tops):.2f} | {np.median(rms):.2f} / {np.percentile(rms, 90):.1f}"
                f" | {off:.2f} % | {cover:.0f} % |"
            )
    print()
    for kind in kinds:
        if (kind, "pcl") in times:
            ratios = []
            for m in methods:
                if m != "pcl" and (kind, m) in times:
                    median, least = times[(kind, "pcl")] / times[(kind, m)]
                    ratios.append(f"{m} {median:.3g}× ({least:.3g}× by the least)")
            print(f"{kind}: PCL's median time over that of " + ", ".join(ratios))


if __name__ == "__main__":
    main()
