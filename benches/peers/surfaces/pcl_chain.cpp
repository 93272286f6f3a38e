// The chain of [brossette2013] with PCL's parts, one thread: crop at 5 m, VoxelGrid, normals, RegionGrowing, planes of
// every cluster by RANSAC until 5 % are left, projection, convex hull.
//
//   pcl_chain CLOUD.pcd STEM RUNS [LEAF_M]
//
// Writes STEM.json (planes and hulls), STEM_pts.bin (float32 x y z label of the thinned cloud) and STEM_ms.txt (median
// and least CPU time of the runs), and prints the CPU time of every part of the fastest in ms.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include <pcl/features/normal_3d.h>
#include <pcl/filters/project_inliers.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/surface/convex_hull.h>

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;

namespace {

constexpr float range_m = 5.0f;
constexpr int neighbours = 30;
constexpr double smoothness_rad = 6.0 * M_PI / 180.0;
constexpr int cluster_min = 150;
constexpr double distance_m = 0.03;
constexpr double rest_ratio = 0.05;

double cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * t.tv_sec + 1e-6 * t.tv_nsec;
}

struct Plane {
  pcl::ModelCoefficients coefficients;
  std::vector<int> members;
  Cloud hull;
};

struct Result {
  Cloud::Ptr thin;
  std::vector<Plane> planes;
  double ms[5];
};

// The planes of one cluster, the largest first, until little of it is left.
void planes_of(const Cloud::Ptr &thin, const std::vector<int> &cluster, std::vector<Plane> &planes) {
  pcl::SACSegmentation<Point> search;
  search.setOptimizeCoefficients(true);
  search.setModelType(pcl::SACMODEL_PLANE);
  search.setMethodType(pcl::SAC_RANSAC);
  search.setDistanceThreshold(distance_m);
  search.setMaxIterations(200);
  search.setInputCloud(thin);
  pcl::IndicesPtr rest(new std::vector<int>(cluster));
  while (rest->size() >= cluster_min && rest->size() > rest_ratio * cluster.size()) {
    Plane plane;
    pcl::PointIndices inliers;
    search.setIndices(rest);
    search.segment(inliers, plane.coefficients);
    if (inliers.indices.size() < cluster_min)
      return;
    std::vector<char> taken(thin->size(), 0);
    for (int i : inliers.indices)
      taken[i] = 1;
    pcl::IndicesPtr left(new std::vector<int>);
    for (int i : *rest)
      if (!taken[i])
        left->push_back(i);
    plane.members = inliers.indices;
    planes.push_back(plane);
    rest = left;
  }
}

Result chain(const Cloud &cloud, float leaf_m) {
  Result result;
  double begin = cpu_ms();
  Cloud::Ptr near(new Cloud);
  for (const Point &p : cloud)
    if (std::isfinite(p.z) && p.x * p.x + p.y * p.y + p.z * p.z <= range_m * range_m)
      near->push_back(p);
  result.thin.reset(new Cloud);
  pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(near);
  grid.setLeafSize(leaf_m, leaf_m, leaf_m);
  grid.filter(*result.thin);
  double end = cpu_ms();
  result.ms[0] = end - begin;

  begin = end;
  pcl::search::KdTree<Point>::Ptr tree(new pcl::search::KdTree<Point>);
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::NormalEstimation<Point, pcl::Normal> estimation;
  estimation.setInputCloud(result.thin);
  estimation.setSearchMethod(tree);
  estimation.setKSearch(neighbours);
  estimation.compute(*normals);
  end = cpu_ms();
  result.ms[1] = end - begin;

  begin = end;
  pcl::RegionGrowing<Point, pcl::Normal> growing;
  growing.setMinClusterSize(cluster_min);
  growing.setMaxClusterSize(10000000);
  growing.setSearchMethod(tree);
  growing.setNumberOfNeighbours(neighbours);
  growing.setInputCloud(result.thin);
  growing.setInputNormals(normals);
  growing.setSmoothnessThreshold(smoothness_rad);
  growing.setCurvatureThreshold(1.0);
  std::vector<pcl::PointIndices> clusters;
  growing.extract(clusters);
  end = cpu_ms();
  result.ms[2] = end - begin;

  begin = end;
  for (const pcl::PointIndices &cluster : clusters)
    planes_of(result.thin, cluster.indices, result.planes);
  end = cpu_ms();
  result.ms[3] = end - begin;

  begin = end;
  for (Plane &plane : result.planes) {
    pcl::ProjectInliers<Point> projection;
    projection.setModelType(pcl::SACMODEL_PLANE);
    projection.setInputCloud(result.thin);
    projection.setIndices(pcl::IndicesPtr(new std::vector<int>(plane.members)));
    projection.setModelCoefficients(pcl::ModelCoefficients::Ptr(new pcl::ModelCoefficients(plane.coefficients)));
    Cloud::Ptr flat(new Cloud);
    projection.filter(*flat);
    pcl::ConvexHull<Point> hull;
    hull.setDimension(2);
    hull.setInputCloud(flat);
    hull.reconstruct(plane.hull);
  }
  result.ms[4] = cpu_ms() - begin;
  return result;
}

void write(const Result &result, const std::string &stem, double median, double least) {
  std::vector<float> label(result.thin->size(), -1.0f);
  for (size_t k = 0; k < result.planes.size(); k++)
    for (int i : result.planes[k].members)
      label[i] = static_cast<float>(k);
  std::ofstream points(stem + "_pts.bin", std::ios::binary);
  for (size_t i = 0; i < label.size(); i++) {
    const Point &p = (*result.thin)[i];
    const float row[4] = {p.x, p.y, p.z, label[i]};
    points.write(reinterpret_cast<const char *>(row), sizeof row);
  }
  std::ofstream planes(stem + ".json");
  planes << "[";
  for (size_t k = 0; k < result.planes.size(); k++) {
    const std::vector<float> &c = result.planes[k].coefficients.values;
    planes << (k ? ",\n" : "") << "{\"plane\":[" << c[0] << "," << c[1] << "," << c[2] << "," << c[3] << "],\"polys\":[[";
    const Cloud &hull = result.planes[k].hull;
    for (size_t i = 0; i < hull.size(); i++)
      planes << (i ? "," : "") << "[" << hull[i].x << "," << hull[i].y << "," << hull[i].z << "]";
    planes << "]]}";
  }
  planes << "]\n";
  std::ofstream(stem + "_ms.txt") << median << " " << least << "\n";
}

} // namespace

int main(int count, char **arguments) {
  if (count < 4) {
    std::fprintf(stderr, "usage: pcl_chain CLOUD.pcd STEM RUNS [LEAF_M]\n");
    return 2;
  }
  pcl::console::setVerbosityLevel(pcl::console::L_ERROR);
  Cloud cloud;
  if (pcl::io::loadPCDFile(arguments[1], cloud) < 0)
    return 1;
  const float leaf_m = count > 4 ? std::atof(arguments[4]) : 0.016f;
  std::vector<double> times;
  double least = INFINITY;
  Result best;
  for (int run = 0; run < std::atoi(arguments[3]); run++) {
    Result result = chain(cloud, leaf_m);
    double ms = 0;
    for (double part : result.ms)
      ms += part;
    times.push_back(ms);
    if (ms < least) {
      least = ms;
      best = result;
    }
  }
  std::sort(times.begin(), times.end());
  write(best, arguments[2], times.empty() ? least : times[times.size() / 2], least);
  std::printf("%zu points, %zu planes: thinning %.1f, normals %.1f, growing %.1f, planes %.1f, hulls %.1f, whole %.1f ms\n",
              best.thin->size(), best.planes.size(), best.ms[0], best.ms[1], best.ms[2], best.ms[3], best.ms[4], least);
}
