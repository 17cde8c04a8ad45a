#include "app/panels/notice.h"

namespace palpate::app {

std::optional<Notice> noticeOf(const LogEvent& event) {
  using Kind = LogEvent::Kind;
  Notice notice{{}, logText(event), event.time_s, event.isFreeze()};
  if (event.isFreeze())
    notice.sentence = "The tissue was pressed too hard and stands still. Go back a little, or start again.";
  else if (event.kind == Kind::RestoredFolded)
    notice.sentence = "The tissue had folded over and would not come back by itself: it was put back to rest.";
  else if (event.isRestore())
    notice.sentence = "That was more than this tissue can take: it was set back to just before. Press more gently.";
  else if (event.kind == Kind::ToolYields)
    notice.sentence = "The tissue gives no further: the probe waits behind your hand. Ease off to go on.";
  else if (event.kind == Kind::ToolLetsGo)
    notice.sentence = "The tissue had closed over the probe, far from your hand: the probe let go of it.";
  else if (event.kind == Kind::DeepContact)
    notice.sentence = "The probe has sunk into the skin, and the force is too low here. Press less hard.";
  else if (event.kind == Kind::ContactOverflow)
    notice.sentence =
        "More skin touches than can be counted, and part of it is left out. Use a smaller probe, or press less.";
  else if (event.kind == Kind::MaterialRefused)
    notice.sentence = "The tissue can't be made that stiff while it runs. Change it in the scene file.";
  else
    return {};
  return notice;
}

}  // namespace palpate::app
