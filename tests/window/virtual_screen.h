#pragma once

#include <memory>
#include <string>

namespace palpate::test {

/// An X server without a screen (Xvfb) and a hand that moves its mouse and presses its keys (XTEST): a window gets them
/// as from a person. The libraries are looked for while running, so that nothing needs them to build.
class VirtualScreen {
 public:
  /// Null where Xvfb or the libraries are not there; `why` then says what is missing.
  static std::unique_ptr<VirtualScreen> open(int width, int height, std::string& why);
  ~VirtualScreen();
  VirtualScreen(const VirtualScreen&) = delete;
  VirtualScreen& operator=(const VirtualScreen&) = delete;

  /// Each has reached the server when it returns; the window gets it with its next look at its events.
  void moveTo(double x, double y);
  void button(int number, bool down);  // 1 left, 2 middle, 3 right, 4 wheel away, 5 wheel towards
  void click(double x, double y);
  void key(const std::string& keysym, bool down);  // X's names: "Next", "Control_L", "x"
  void tap(const std::string& keysym);
  void tapWith(const std::string& modifier, const std::string& keysym);
  void type(const std::string& text);  // lower case, digits, '.', '-', '/', '_'
  /// Resizes the window that is under the pointer, past what it allows a person.
  void resize(unsigned width, unsigned height);

 private:
  struct Server;
  explicit VirtualScreen(std::unique_ptr<Server> server);
  void finish();

  std::unique_ptr<Server> server_;
};

}  // namespace palpate::test
