#include "igtl_messages.h"

#include <igtl_util.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace palpate::igtl_bridge {

namespace {

constexpr double mm = 1e-3;         // m
constexpr double rigid = 1e-3;      // how far columns may be from unit and perpendicular: trackers send floats
constexpr double farthest = 10;     // m, as of a device's handle
constexpr double nudge = 1.237e-5;  // of a voxel: no line through voxels meets a vertex of the skin

/// Where vertical lines through voxels pass the skin: height, and 1 where it is left upwards, else -1.
using Crossings = std::vector<std::vector<std::pair<double, int>>>;

Eigen::Vector3d vertex(const Skin& skin, std::size_t corner) {
  const float* x = &skin.x[3 * static_cast<std::size_t>(skin.corners[corner])];
  return {x[0], x[1], x[2]};
}

/// @param origin  m, of the first voxel's centre; @param h  m
Crossings crossings(const Skin& skin, const Eigen::Vector3d& origin, double h, const Eigen::Vector3i& count) {
  Crossings result(static_cast<std::size_t>(count.x()) * static_cast<std::size_t>(count.y()));
  for (std::size_t t = 0; t < skin.corners.size(); t += 3) {
    const Eigen::Vector3d a = vertex(skin, t), b = vertex(skin, t + 1), c = vertex(skin, t + 2);
    const Eigen::Vector3d low = (a.cwiseMin(b).cwiseMin(c) - origin) / h;
    const Eigen::Vector3d high = (a.cwiseMax(b).cwiseMax(c) - origin) / h;
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    for (int i = std::max(0, static_cast<int>(low.x()) - 1); i < count.x() && i <= high.x(); ++i)
      for (int j = std::max(0, static_cast<int>(low.y()) - 1); j < count.y() && j <= high.y(); ++j) {
        const Eigen::Vector3d p = origin + h * Eigen::Vector3d(i + nudge, j + nudge * 0.7, 0);
        const auto side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
          return (to.x() - from.x()) * (p.y() - from.y()) - (to.y() - from.y()) * (p.x() - from.x()) > 0;
        };
        const bool first = side(a, b);
        if (normal.z() == 0 || side(b, c) != first || side(c, a) != first) continue;
        const double z = a.z() - (normal.x() * (p.x() - a.x()) + normal.y() * (p.y() - a.y())) / normal.z();
        result[static_cast<std::size_t>(j * count.x() + i)].emplace_back(z, normal.z() > 0 ? 1 : -1);
      }
  }
  return result;
}

}  // namespace

std::uint64_t numberAt(const unsigned char* bytes, int count) {
  std::uint64_t number = 0;
  for (int k = 0; k < count; ++k) number = number << 8 | bytes[k];
  return number;
}

bool transformOf(const unsigned char* header, std::vector<unsigned char>& body, igtl::Matrix4x4& matrix,
                 std::string& problem) {
  constexpr int checksum_at = 50;
  if (crc64(body.data(), body.size(), 0) != numberAt(header + checksum_at, 8)) {
    problem = "a TRANSFORM whose checksum is wrong";
    return false;
  }
  // Version 2 has a header (its length and those of two kinds of metadata) before the matrix, metadata after it.
  constexpr std::size_t least_extension = 12, matrix_bytes = 48;
  const bool extended = numberAt(header, 2) >= 2;
  std::uint64_t begin = 0, after = 0;
  if (extended && body.size() >= least_extension)
    begin = numberAt(body.data(), 2), after = numberAt(&body[2], 2) + numberAt(&body[4], 4);
  if ((extended && begin < least_extension) || begin + matrix_bytes + after != body.size()) {
    problem = "a TRANSFORM of " + std::to_string(body.size()) + " bytes";
    return false;
  }
  igtl::IdentityMatrix(matrix);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r)
      matrix[r][c] = std::bit_cast<float>(
          static_cast<std::uint32_t>(numberAt(&body[begin + static_cast<std::size_t>(4 * (3 * c + r))], 4)));
  return true;
}

std::optional<std::array<double, 7>> poseOf(const igtl::Matrix4x4& matrix, std::string& problem) {
  Eigen::Matrix3d turn;
  Eigen::Vector3d place;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) turn(r, c) = matrix[r][c];
    place[r] = mm * matrix[r][3];
  }
  if (!turn.allFinite() || !place.allFinite())
    problem = "a number of it is not finite";
  else if (!(turn.transpose() * turn).isIdentity(rigid) || turn.determinant() < 0)
    problem = "it is no rigid motion";
  else if (place.cwiseAbs().maxCoeff() > farthest)
    problem = "it is more than 10 m away; its numbers are mm";
  else
    problem.clear();
  if (!problem.empty()) return {};
  const Eigen::Quaterniond q = Eigen::Quaterniond(turn).normalized();
  return std::array<double, 7>{place.x(), place.y(), place.z(), q.x(), q.y(), q.z(), q.w()};
}

void matrixOf(const double* pose, igtl::Matrix4x4& matrix) {
  const Eigen::Matrix3d turn = Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]).toRotationMatrix();
  igtl::IdentityMatrix(matrix);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix[r][c] = static_cast<float>(turn(r, c));
    matrix[r][3] = static_cast<float>(pose[r] / mm);
  }
}

igtl::PolyDataMessage::Pointer surfaceMessage(const Skin& skin, const std::string& device) {
  auto points = igtl::PolyDataPointArray::New();
  const auto in_mm = [](float x) { return static_cast<float>(x / mm); };
  for (std::size_t v = 0; v < skin.x.size(); v += 3)
    points->AddPoint(in_mm(skin.x[v]), in_mm(skin.x[v + 1]), in_mm(skin.x[v + 2]));
  auto polygons = igtl::PolyDataCellArray::New();
  for (std::size_t t = 0; t < skin.corners.size(); t += 3) {
    igtlUint32 triangle[3];
    std::copy_n(&skin.corners[t], 3, triangle);
    polygons->AddCell(3, triangle);
  }
  auto message = igtl::PolyDataMessage::New();
  message->SetDeviceName(device.c_str());
  message->SetPoints(points);
  message->SetPolygons(polygons);
  return message;
}

igtl::ImageMessage::Pointer volumeMessage(const Skin& skin, int cells, const std::string& device) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max()), high = -low;
  for (std::size_t v = 0; v < skin.x.size(); v += 3) {
    const Eigen::Vector3d x(skin.x[v], skin.x[v + 1], skin.x[v + 2]);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double h = (high - low).maxCoeff() / cells;
  const Eigen::Vector3i count = ((high - low) / h).array().ceil().max(1).cast<int>();
  const Eigen::Vector3d origin = low + Eigen::Vector3d::Constant(0.5 * h);
  auto message = igtl::ImageMessage::New();
  message->SetDeviceName(device.c_str());
  message->SetDimensions(count.x(), count.y(), count.z());
  const auto spacing = static_cast<float>(h / mm);
  message->SetSpacing(spacing, spacing, spacing);
  message->SetScalarTypeToUint8();
  message->SetCoordinateSystem(igtl::ImageMessage::COORDINATE_RAS);
  const Eigen::Vector3d middle = (origin + 0.5 * h * (count.cast<double>() - Eigen::Vector3d::Ones())) / mm;
  igtl::Matrix4x4 matrix;
  igtl::IdentityMatrix(matrix);
  for (int r = 0; r < 3; ++r) matrix[r][3] = static_cast<float>(middle[r]);
  message->SetMatrix(matrix);
  message->AllocateScalars();
  auto* voxel = static_cast<igtlUint8*>(message->GetScalarPointer());
  const Crossings lines = crossings(skin, origin, h, count);
  for (int k = 0; k < count.z(); ++k)
    for (const auto& line : lines) {
      int inside = 0;
      for (const auto& [z, out] : line)
        if (z > origin.z() + k * h) inside += out;  // surfaces above: left once more than entered from inside
      *voxel++ = inside > 0 ? 1 : 0;
    }
  return message;
}

}  // namespace palpate::igtl_bridge
