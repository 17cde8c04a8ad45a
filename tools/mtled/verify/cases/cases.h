#pragma once

#include "mtled/verify/verification_case.h"

namespace palpate::tools {

/// Of every displacement field that the model's shape functions hold but rigid motions: the energy that its scheme
/// sees at
/// rest over mu int |grad u|^2 / 2. One near 0 would be a mode without energy. One material; dense, for some hundred
/// nodes.
/// @return (3 node_count - 6) ascending
std::vector<double> energyShares(const Model& model);

CaseResult approximationCase(const CaseContext& context);
CaseResult cubeCase(const CaseContext& context);
CaseResult boxExtensionCase(const CaseContext& context);
CaseResult boxCompressionCase(const CaseContext& context);
CaseResult halfEllipsoidCase(const CaseContext& context);
CaseResult gelCylinderCase(const CaseContext& context);
CaseResult modesCase(const CaseContext& context);
CaseResult lockingCase(const CaseContext& context);
CaseResult torsionCase(const CaseContext& context);
CaseResult thickSphereCase(const CaseContext& context);
CaseResult cookCase(const CaseContext& context);
CaseResult flexureCase(const CaseContext& context);
CaseResult brainShiftCase(const CaseContext& context);

}  // namespace palpate::tools
