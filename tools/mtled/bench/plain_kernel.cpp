#include "mtled/bench/plain_kernel.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "mechanics/materials/laws.h"

namespace palpate::tools {

PlainKernel::PlainKernel(const std::vector<int>& order, const ShapeTable& shape, const std::vector<double>& volume,
                         const Material& material)
    : mu_(material.shear_modulus), K_(material.bulk_modulus) {
  if (material.law != lawNumber<NeoHookean>() || material.barrier_strength != 0)
    throw std::invalid_argument("the plain kernel knows the neo-Hookean material without barrier only");
  for (const int q : order) {
    if (q < 0) continue;
    node_.insert(node_.end(), shape.node.begin() + shape.begin[q], shape.node.begin() + shape.begin[q + 1]);
    gradN_.insert(gradN_.end(), shape.gradN.begin() + shape.begin[q], shape.gradN.begin() + shape.begin[q + 1]);
    begin_.push_back(static_cast<std::int32_t>(node_.size()));
    volume_.push_back(volume[q]);
  }
}

void PlainKernel::pointForces(int begin, int end, const Vec3* u, Vec3* f) const {
  for (int q = begin; q < end; ++q) {
    Mat3 F = Mat3::Identity();
    for (int e = begin_[q]; e < begin_[q + 1]; ++e) F.noalias() += u[node_[e]] * gradN_[e].transpose();

    const double J = F.determinant();
    const Mat3 inverse_transposed = F.inverse().transpose();
    const double cube_root = std::cbrt(J);
    const Mat3 P = mu_ / (cube_root * cube_root) * (F - F.squaredNorm() / 3 * inverse_transposed) +
                   K_ * (J - 1) * J * inverse_transposed;
    const Mat3 PV = volume_[q] * P;
    for (int e = begin_[q]; e < begin_[q + 1]; ++e) f[node_[e]].noalias() -= PV * gradN_[e];
  }
}

void PlainKernel::forces(const std::vector<Vec3>& u, std::vector<Vec3>& f, SpinTeam& team) {
  f.resize(u.size());
  partial_.resize(team.size() - 1, std::vector<Vec3>(u.size()));
  auto each = [&](int member, int members) {
    std::vector<Vec3>& mine = member == 0 ? f : partial_[member - 1];
    std::fill(mine.begin(), mine.end(), Vec3::Zero());
    const auto points = static_cast<long long>(volume_.size());
    pointForces(static_cast<int>(points * member / members), static_cast<int>(points * (member + 1) / members),
                u.data(), mine.data());
  };
  team.run([](void* context, int member, int members) { (*static_cast<decltype(each)*>(context))(member, members); },
           &each);
  for (const auto& part : partial_)
    for (std::size_t i = 0; i < f.size(); ++i) f[i] += part[i];
}

double PlainKernel::streamedBytes() const {
  return static_cast<double>(gradN_.size() * sizeof(Vec3) + (node_.size() + begin_.size()) * sizeof(std::int32_t) +
                             volume_.size() * sizeof(double));
}

}  // namespace palpate::tools
