#pragma once

#include "contact/tool.h"

/// Every tool there is, a line each; engine/contact/tools/ has a file for each, which defines tool_types::<name>.
/// Model hashes number the tools by this order: a new one comes last.
#define PALPATE_TOOLS(TOOL) \
  TOOL(Sphere)              \
  TOOL(FlatCylinder)        \
  TOOL(Capsule)             \
  TOOL(Cone)

namespace palpate {

#define PALPATE_ENUMERATOR(name) name,
enum class ToolKind : int { PALPATE_TOOLS(PALPATE_ENUMERATOR) };
#undef PALPATE_ENUMERATOR

namespace tool_types {
#define PALPATE_DECLARATION(name) extern const ToolType name;
PALPATE_TOOLS(PALPATE_DECLARATION)
#undef PALPATE_DECLARATION
}  // namespace tool_types

}  // namespace palpate
