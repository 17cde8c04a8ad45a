#include "mechanics/relaxation.h"

#include <algorithm>
#include <cmath>

namespace palpate {

RelaxationStep relaxationStep(const Material& material, double h, int max_term_count) {
  RelaxationStep step;
  step.term_count = std::min(material.relaxation_count, max_term_count);
  for (int i = 0; i < step.term_count; ++i) {
    const double g = material.relaxation[2 * i], tau = material.relaxation[2 * i + 1], x = h / tau;
    const double gone = -std::expm1(-x), mean = gone / x;  // 1 - E, and the mean of e^(-t / tau) over the step
    const double a = 1 - mean, b = mean - (1 - gone);
    step.term[i] = {g, 1 / tau, g * a, g * ((1 - gone) * a + b), gone};
  }
  return step;
}

template <class Real>
RelaxationHistoryOf<Real> makeRelaxationHistory(std::size_t batch_count, const std::vector<Material>& materials) {
  RelaxationHistoryOf<Real> history;
  for (const Material& m : materials) history.term_count = std::max(history.term_count, m.relaxation_count);
  history.Z.assign(batch_count * static_cast<std::size_t>(history.term_count) * history.batch_numbers, Real(0));
  return history;
}

template RelaxationHistoryOf<float> makeRelaxationHistory(std::size_t, const std::vector<Material>&);
template RelaxationHistoryOf<double> makeRelaxationHistory(std::size_t, const std::vector<Material>&);

RelaxedStress relaxedStress(const RelaxationStep& step, const Mat3& F, const Mat3& P, Mat3* Z) {
  const double J = F.determinant(), Jc = std::max(J, Material::min_isochoric_J);
  Mat3 cof;
  cof << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  const Mat3 P_iso = P - P.cwiseProduct(F).sum() / (3 * Jc) * cof;
  // Of an inverted point nothing is learnt: its law has left the formula.
  const Mat3 S = J < Material::min_isochoric_J ? Mat3::Zero() : Mat3(std::pow(J, -1.0 / 3) * cof.transpose() * P_iso);
  const Mat3 C = std::pow(Jc, -2.0 / 3) * F.transpose() * F, E = (C - Mat3::Identity()) / 2;
  Mat3 Q = Mat3::Zero(), flow = Mat3::Zero();
  for (int i = 0; i < step.term_count; ++i) {
    const auto& term = step.term[i];
    const Mat3 Q_i = term.now * S + (Z != nullptr ? Z[i] : Mat3::Zero());
    if (Z != nullptr) Z[i] += term.later * S - term.decay * Z[i];
    Q += Q_i;
    flow += term.rate * (term.g * S - Q_i);
  }
  const Mat3 dev = std::pow(Jc, -2.0 / 3) * F * Q - C.cwiseProduct(Q).sum() / (3 * Jc) * cof;
  return {P - dev, E.cwiseProduct(Q).sum(), E.cwiseProduct(flow).sum()};
}

}  // namespace palpate
