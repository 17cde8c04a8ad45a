#pragma once

#include "mtled/verification_case.h"

namespace palpate {

CaseResult approximationCase(const CaseContext& context);
CaseResult cubeCase(const CaseContext& context);
CaseResult boxExtensionCase(const CaseContext& context);
CaseResult boxCompressionCase(const CaseContext& context);
CaseResult halfEllipsoidCase(const CaseContext& context);
CaseResult gelCylinderCase(const CaseContext& context);
CaseResult modesCase(const CaseContext& context);
CaseResult lockingCase(const CaseContext& context);
CaseResult torsionCase(const CaseContext& context);
CaseResult flexureCase(const CaseContext& context);

}  // namespace palpate
