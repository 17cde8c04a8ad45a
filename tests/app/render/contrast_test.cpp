// What can be read, and by whom: contrast as WCAG 2 has it, colour vision as Machado, Oliveira and Fernandes (2009).
#include <imgui.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "app/render/colour.h"
#include "app/render/colour_map.h"
#include "app/render/theme.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// Red, green and blue of `top` over `ground`, sRGB-encoded 0..1.
Vec3f over(const ImVec4& top, const Vec3f& ground) { return top.w * Vec3f(top.x, top.y, top.z) + (1 - top.w) * ground; }
Vec3f over(ImU32 top, const Vec3f& ground) { return over(ImGui::ColorConvertU32ToFloat4(top), ground); }

/// Relative luminance, WCAG 2.1.
float luminance(const Vec3f& c) {
  return 0.2126F * decodeSrgb(c.x()) + 0.7152F * decodeSrgb(c.y()) + 0.0722F * decodeSrgb(c.z());
}

float contrast(const Vec3f& a, const Vec3f& b) {
  const float la = luminance(a) + 0.05F, lb = luminance(b) + 0.05F;
  return std::max(la, lb) / std::min(la, lb);
}

/// What eyes without middle (deutan) or long (protan) cones see, of severity 1, in linear light.
Vec3f seen(const Vec3f& encoded, bool deutan) {
  Eigen::Matrix3f m;
  if (deutan)
    m << 0.367322F, 0.860646F, -0.227968F, 0.280085F, 0.672501F, 0.047413F, -0.011820F, 0.042940F, 0.968881F;
  else
    m << 0.152286F, 1.052583F, -0.204868F, 0.114503F, 0.786281F, 0.099216F, -0.003882F, -0.048116F, 1.051998F;
  const Vec3f linear = m * encoded.unaryExpr([](float c) { return decodeSrgb(c); });
  return linear.unaryExpr([](float c) { return encodeSrgb(std::clamp(c, 0.0F, 1.0F)); });
}

float distance(const Vec3f& a, const Vec3f& b) { return (labFromSrgb(a) - labFromSrgb(b)).norm(); }

constexpr float readable = 4.5F;  // WCAG 2.1, 1.4.3 (AA), text of any size

/// Dear ImGui's colours as the panels have them.
class Style {
 public:
  Style() : context_(ImGui::CreateContext()) { makeTheme(1); }
  ~Style() { ImGui::DestroyContext(context_); }
  Vec3f ground(ImGuiCol what, const Vec3f& below) const { return over(ImGui::GetStyle().Colors[what], below); }

 private:
  ImGuiContext* context_;
};

}  // namespace

TEST_CASE("All that is written in the panels can be read", "[panels][contrast]") {
  const Style style;
  // A pane lets a little of the picture through: at worst of white.
  for (const float behind : {0.0F, 1.0F}) {
    const Vec3f pane = style.ground(ImGuiCol_WindowBg, Vec3f::Constant(behind));
    const Vec3f popup = style.ground(ImGuiCol_PopupBg, Vec3f::Constant(behind));
    for (const auto& [name, ink] : {std::pair{"text", colours::text},
                                    {"faint", colours::faint},
                                    {"stale", colours::stale},
                                    {"accent", colours::accent},
                                    {"good", colours::good},
                                    {"warning", colours::warning},
                                    {"bad", colours::bad}}) {
      INFO(name << " over " << behind);
      CHECK(contrast(over(ink, pane), pane) >= readable);
      CHECK(contrast(over(ink, popup), popup) >= readable);
    }
    for (const ImGuiCol what : {ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive, ImGuiCol_Button,
                                ImGuiCol_ButtonHovered, ImGuiCol_ButtonActive, ImGuiCol_Header, ImGuiCol_HeaderHovered,
                                ImGuiCol_HeaderActive, ImGuiCol_PlotHistogram}) {
      INFO(ImGui::GetStyleColorName(what));
      const Vec3f ground = style.ground(what, pane);
      CHECK(contrast(over(colours::text, ground), ground) >= readable);
    }
    for (const auto& [grab, frame] : {std::pair{ImGuiCol_SliderGrab, ImGuiCol_FrameBg},
                                      {ImGuiCol_SliderGrab, ImGuiCol_FrameBgHovered},
                                      {ImGuiCol_SliderGrabActive, ImGuiCol_FrameBgActive}}) {
      const Vec3f ground = style.ground(frame, pane);
      CHECK(contrast(style.ground(grab, ground), ground) >= 3);  // what is moved: WCAG 2.1, 1.4.11
    }
    for (const ImU32 banner : {colours::frozen_banner, colours::notice_banner}) {
      const Vec3f ground = over(banner, Vec3f::Constant(behind));
      CHECK(contrast(over(colours::text, ground), ground) >= readable);
    }
  }
  const Vec3f plot = over(colours::plot_ground, Vec3f::Zero());
  CHECK(contrast(over(colours::faint, plot), plot) >= readable);
  CHECK(contrast(over(colours::accent, plot), plot) >= 3);  // lines: WCAG 2.1, 1.4.11
  CHECK(contrast(over(colours::raw, plot), plot) >= 3);
}

TEST_CASE("The colour maps' lightness rises evenly for every eye, and what lies outside stands apart", "[contrast]") {
  constexpr int steps = 32;
  for (const bool deutan : {true, false}) {
    float last = -1, last_low = 101, last_high = -1;
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const Vec3f c = seen(colourOf(ColourMap::Displacement, t), deutan);
      const float L = labFromSrgb(c).x();
      CHECK(L > last);
      last = L;
      CHECK(distance(c, seen(aboveColour(), deutan)) > 20);
      CHECK(distance(c, seen(belowColour(), deutan)) > 8);
      // Towards both ends of J it becomes darker, and the ends differ in hue.
      const float low = labFromSrgb(seen(colourOf(ColourMap::J, 0.5 - 0.5 * t), deutan)).x();
      const float high = labFromSrgb(seen(colourOf(ColourMap::J, 0.5 + 0.5 * t), deutan)).x();
      if (k > 0) {
        CHECK(low < last_low);
        CHECK(high < last_high);
      }
      last_low = low;
      last_high = high;
    }
    CHECK(distance(seen(colourOf(ColourMap::J, 0), deutan), seen(colourOf(ColourMap::J, 1), deutan)) > 40);
    CHECK(distance(seen(aboveColour(), deutan), seen(belowColour(), deutan)) > 40);
  }
}
