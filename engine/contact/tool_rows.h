#pragma once

#include <array>
#include <optional>
#include <span>

#include "contact/contact_row.h"
#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool.h"
#include "contact/tool_profile.h"
#include "contact/tool_set.h"

namespace palpate {

/// How a hand holds a tool: as a motor that is as strong as this, and gives way to more within the step.
///   x_tool = wanted + way,   |F| <= max_force,   way = 0 or |F| = max_force
/// F is the force on the tool. Jaws open likewise to more than their max_pinch. Beyond `longest` it gives way no
/// further, and yet pushes no harder: the skin is deeper in it then.
struct ToolHold {
  double max_force = 0, max_pinch = 0;  // N; 0: it never gives way
  double longest = 0;                   // m
  // By how much it gives way (m): as a first guess, which the pose has in it already; receives the truth.
  Vec3 way = Vec3::Zero();
  double opening = 0;
};

/// One of several tools that touch the same skin.
struct TouchingTool {
  const ToolShape* shape = nullptr;
  Pose pose, previous_pose;
  double friction = 0;
  ContactState* contact = nullptr;
  ContactScratch* scratch = nullptr;
  ToolHold* hold = nullptr;   // null: nothing moves it from its pose. Bodies of one tool have the same, side by side
  Vec3 apart = Vec3::Zero();  // by which it moves per m of opening; 0: no finger of jaws
  Vec3 force = Vec3::Zero();  // N, on it; receives it
};

/// The rows of tools: vertices of the skin, and samples of stretched faces (contact.samples), which take part like
/// vertices; a force on one goes to its corners by their shares. With penetration d at the end of the step and the
/// layer's stiffness K = k_v a_v (skin.layer, and the vertex's area) the law is ContactRow's with
///   f_n = K min(max(d, 0), most_depths skin.layer_depth)
/// Forces act along and across the normal of where the point was at the step's start, as the tissue's forces are those
/// of it, so contact never creates energy; f_t is its own memory of the stick, so static friction does not creep. A
/// point that is deep in the tool is pushed out by the side it came in by (tool_side.h). A vertex whose position is not
/// finite takes no part.
///
/// The force on a tool balances the step's start (the central difference's acceleration is that at u), so its work is
/// force . (mean of this and the last step's way).
///
/// A tool's pose and previous pose are at most ~1 mm or R/2 apart for no tunnelling, whichever is less.
class ToolRows final : public ContactGroup {
 public:
  ToolRows(const ContactStep& step, std::span<TouchingTool> tools);

  std::size_t makeRows() override;
  bool sweep(bool forwards) override;
  /// Keeps the forces for the next step, and says what each tool felt.
  void finish();

 private:
  /// Rotations and places of one step, computed once.
  struct Motion {
    Motion(const Pose& from, const Pose& to);

    Mat3 world_from_tool, world_from_old_tool, turn;
    Vec3 position, old_position;
  };

  /// One of the tools' bodies.
  struct Body {
    explicit Body(TouchingTool& touching);

    std::span<ToolRow> rows() const { return {tool->scratch->row.data(), row_count}; }
    Eigen::Vector4f turned(const Float4& force) const;
    /// Goes to where its hold has it.
    void follow();

    TouchingTool* tool;
    Motion motion;
    ToolProfile profile;
    std::size_t row_count = 0;
    Vec3 given = Vec3::Zero();                        // m, by how much it has given way in its pose
    Eigen::Vector4f shift = Eigen::Vector4f::Zero();  // m, from the pose, as far as it has moved since
  };
  using Bodies = std::span<std::optional<Body>>;

  /// A way that a tool can give: as a whole along the force on it, or by its opening.
  struct Giving {
    Bodies bodies;  // of one tool
    bool opens;
    double limit;       // N
    Vec3 out{0, 0, 0};  // unit, as a whole
    double size = 0;    // N, what the hand bears

    void measure();
    Vec3 along(const Body& body) const { return opens ? body.tool->apart : out; }
  };

  void makeRows(Body& body);
  template <class Call>
  void forEachGiving(Call call);
  void scale(const Giving& giving, float share);
  double distance(const Giving& giving) const;
  bool giveWay(Giving giving);

  const ContactStep& step_;
  std::array<std::optional<Body>, max_tool_bodies> body_;
  std::size_t count_;  // of bodies
  Sweeps sweeps_;
};

}  // namespace palpate
