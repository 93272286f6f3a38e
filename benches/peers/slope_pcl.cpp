// The chain of [meng] with PCL's parts, one thread: statistical filter (m = 30, kappa = 2), PROSAC for
// the ground, PROSAC for the slope in what is left within an angle, the line of both planes.
//
//   slope_pcl CLOUD.pcd RUNS
//
// Prints the median wall time of every part in ms, the angle in degrees, and the points kept.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <pcl/common/angles.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>
#include <pcl/segmentation/sac_segmentation.h>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

namespace {

double now_ms() {
  using clock = std::chrono::steady_clock;
  return std::chrono::duration<double, std::milli>(clock::now().time_since_epoch()).count();
}

// The plane of a cloud whose normal is within an angle of an axis; its points leave the cloud.
bool take_plane(Cloud::Ptr &cloud, const Eigen::Vector3f &axis, double angle, int method,
                pcl::ModelCoefficients &plane) {
  pcl::SACSegmentation<pcl::PointXYZ> search;
  search.setOptimizeCoefficients(true);
  search.setModelType(pcl::SACMODEL_PERPENDICULAR_PLANE);
  search.setMethodType(method);
  search.setAxis(axis);
  search.setEpsAngle(angle);
  search.setDistanceThreshold(0.03);
  search.setMaxIterations(600);
  search.setInputCloud(cloud);
  pcl::PointIndices::Ptr inliers(new pcl::PointIndices);
  search.segment(*inliers, plane);
  if (inliers->indices.empty())
    return false;
  pcl::ExtractIndices<pcl::PointXYZ> extract;
  extract.setInputCloud(cloud);
  extract.setIndices(inliers);
  extract.setNegative(true);
  Cloud::Ptr rest(new Cloud);
  extract.filter(*rest);
  cloud = rest;
  return true;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: slope_pcl CLOUD.pcd RUNS\n");
    return 2;
  }
  Cloud::Ptr raw(new Cloud);
  if (pcl::io::loadPCDFile(argv[1], *raw) < 0)
    return 1;
  // The field of view: half a turn about x.
  Cloud::Ptr view(new Cloud);
  for (const auto &p : *raw)
    if (std::isfinite(p.x) && p.x >= 0.0f)
      view->push_back(p);
  const int runs = std::atoi(argv[2]);
  std::vector<double> filter_ms, ground_ms, slope_ms, all_ms;
  double angle = 0.0;
  size_t kept = 0;
  for (int run = 0; run < runs; ++run) {
    const double start = now_ms();
    Cloud::Ptr cloud(new Cloud);
    pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(view);
    filter.setMeanK(30);
    filter.setStddevMulThresh(2.0);
    filter.filter(*cloud);
    kept = cloud->size();
    const double filtered = now_ms();
    pcl::ModelCoefficients ground, slope;
    if (!take_plane(cloud, Eigen::Vector3f::UnitZ(), pcl::deg2rad(35.0), pcl::SAC_PROSAC, ground))
      return 1;
    const double grounded = now_ms();
    const Eigen::Vector3f up(ground.values[0], ground.values[1], ground.values[2]);
    if (!take_plane(cloud, up, pcl::deg2rad(45.0), pcl::SAC_PROSAC, slope))
      return 1;
    // Line, orientation and angle of the two planes.
    const Eigen::Vector3f n(slope.values[0], slope.values[1], slope.values[2]);
    const Eigen::Vector3f line = n.cross(up);
    angle = std::asin(std::min(1.0f, line.norm())) * 180.0 / M_PI;
    const double end = now_ms();
    filter_ms.push_back(filtered - start);
    ground_ms.push_back(grounded - filtered);
    slope_ms.push_back(end - grounded);
    all_ms.push_back(end - start);
  }
  std::printf("PCL: %zu points in view, %zu kept; filter %.2f ms, ground %.2f ms, slope %.2f ms, all %.2f ms; "
              "slope %.2f deg\n",
              view->size(), kept, median(filter_ms), median(ground_ms), median(slope_ms), median(all_ms), angle);
  return 0;
}
