#pragma once

#include <imgui.h>

#include <map>
#include <string>
#include <vector>

#include "app/panels/layout.h"
#include "app/render/theme.h"
#include "base/number_text.h"

namespace palpate::app {

/// The last of these that is no wider than `width`, px, or the first: a number is left out rather than cut.
const std::string& lastThatFits(const std::vector<std::string>& texts, float width);

/// `text` shortened with an ellipsis so that it is at most `width` px wide in the present font.
std::string fitted(const std::string& text, float width);

/// A window that stands exactly in `place`, without title, move or resize.
/// As ImGui::Begin: call ImGui::End whatever it returns.
bool beginPane(const char* id, const Rect& place, ImGuiWindowFlags more = 0);

/// A pane that showed its end shows it again, whatever its size has become. Before its begin.
void keepAtEnd(const char* id);

/// A section of a column with a heading that folds it. False where it is folded.
bool beginCard(const Theme& theme, const char* title, bool open = true);

/// A line with a faint name on the left and a value on the right; a hint shows on hovering.
void row(const char* name, const std::string& value, ImU32 colour = colours::text, const char* hint = nullptr);

/// Text in the small font, faint, wrapped.
void note(const Theme& theme, const std::string& text, ImU32 colour = colours::faint);

/// A button that is greyed out with the reason as its hint where `enabled` is false.
bool button(const char* label, float width, bool enabled = true, const char* reason = nullptr);

/// Goes back by half a second; not while a script or recording moves the probe.
bool undoButton(float width, bool by_hand);

/// Whether a menu or a list of choices is folded out; and folds all of them in.
bool menuOpen();
void closeMenus();

/// Where the buttons stood when they were last drawn, px, by their labels: for who drives the window from outside.
const std::map<std::string, Rect>& buttonPlaces();

/// A row with a slider below it, so that no handle hides the value; greyed out where there is a reason not to move it.
bool slider(const char* name, float& value, float low, float high, const char* pattern, const std::string& reason);

/// A filled rounded label, e.g. "RUNNING", on the present line.
void badge(const Theme& theme, const char* text, ImU32 colour);

}  // namespace palpate::app
