#include "window/virtual_screen.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace palpate::test {

namespace {

using Display = void;
using XWindow = unsigned long;

template <class Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (function == nullptr) throw std::runtime_error(std::string("no ") + name);
}

/// Starts Xvfb, which writes its display's number into a pipe once it is ready. Returns its process, or -1.
pid_t startServer(int width, int height, std::string& display) {
  int ends[2] = {-1, -1};
  if (pipe(ends) != 0) return -1;
  const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
  const std::string number = std::to_string(ends[1]);
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    const int nothing = ::open("/dev/null", O_RDWR);
    dup2(nothing, 1);
    dup2(nothing, 2);
    execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", screen.c_str(), "-nolisten", "tcp",
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  char letter = 0;
  while (process > 0 && read(ends[0], &letter, 1) == 1 && letter != '\n') display += letter;
  close(ends[0]);
  if (process > 0 && display.empty()) waitpid(process, nullptr, 0);
  return display.empty() ? -1 : process;
}

}  // namespace

struct VirtualScreen::Server {
  pid_t process = -1;
  void *x11 = nullptr, *xtst = nullptr;
  Display* display = nullptr;

  Display* (*open_display)(const char*) = nullptr;
  int (*close_display)(Display*) = nullptr;
  int (*sync)(Display*, int) = nullptr;
  unsigned long (*keysym_of)(const char*) = nullptr;
  unsigned char (*keycode_of)(Display*, unsigned long) = nullptr;
  int (*query_pointer)(Display*, XWindow, XWindow*, XWindow*, int*, int*, int*, int*, unsigned*) = nullptr;
  XWindow (*root_window)(Display*) = nullptr;
  int (*resize_window)(Display*, XWindow, unsigned, unsigned) = nullptr;
  int (*fake_key)(Display*, unsigned, int, unsigned long) = nullptr;
  int (*fake_button)(Display*, unsigned, int, unsigned long) = nullptr;
  int (*fake_motion)(Display*, int, int, int, unsigned long) = nullptr;

  ~Server() {
    if (display != nullptr) close_display(display);
    if (process > 0) {
      kill(process, SIGTERM);
      waitpid(process, nullptr, 0);
    }
  }

  void bind() {
    find(x11, "XOpenDisplay", open_display);
    find(x11, "XCloseDisplay", close_display);
    find(x11, "XSync", sync);
    find(x11, "XStringToKeysym", keysym_of);
    find(x11, "XKeysymToKeycode", keycode_of);
    find(x11, "XQueryPointer", query_pointer);
    find(x11, "XDefaultRootWindow", root_window);
    find(x11, "XResizeWindow", resize_window);
    find(xtst, "XTestFakeKeyEvent", fake_key);
    find(xtst, "XTestFakeButtonEvent", fake_button);
    find(xtst, "XTestFakeMotionEvent", fake_motion);
  }
};

VirtualScreen::VirtualScreen(std::unique_ptr<Server> server) : server_(std::move(server)) {}
VirtualScreen::~VirtualScreen() = default;

std::unique_ptr<VirtualScreen> VirtualScreen::open(int width, int height, std::string& why) {
  auto server = std::make_unique<Server>();
  server->x11 = dlopen("libX11.so.6", RTLD_NOW | RTLD_GLOBAL);
  server->xtst = dlopen("libXtst.so.6", RTLD_NOW);
  if (server->x11 == nullptr || server->xtst == nullptr) {
    why = "libX11.so.6 or libXtst.so.6 is not there; tools/setup installs them";
    return nullptr;
  }
  server->bind();
  std::string display;
  server->process = startServer(width, height, display);
  if (server->process < 0) {
    why = "Xvfb can't be started; tools/setup installs it";
    return nullptr;
  }
  setenv("DISPLAY", (":" + display).c_str(), 1);
  server->display = server->open_display(nullptr);
  if (server->display == nullptr) {
    why = "Xvfb takes no connection";
    return nullptr;
  }
  return std::unique_ptr<VirtualScreen>(new VirtualScreen(std::move(server)));
}

void VirtualScreen::finish() { server_->sync(server_->display, 0); }

void VirtualScreen::moveTo(double x, double y) {
  server_->fake_motion(server_->display, 0, static_cast<int>(x + 0.5), static_cast<int>(y + 0.5), 0);
  finish();
}

void VirtualScreen::button(int number, bool down) {
  server_->fake_button(server_->display, static_cast<unsigned>(number), down ? 1 : 0, 0);
  finish();
}

void VirtualScreen::click(double x, double y) {
  moveTo(x, y);
  button(1, true);
  button(1, false);
}

void VirtualScreen::key(const std::string& keysym, bool down) {
  const unsigned code = server_->keycode_of(server_->display, server_->keysym_of(keysym.c_str()));
  if (code == 0) throw std::runtime_error("the keyboard has no key " + keysym);
  // GLFW takes a key that comes down sooner than 20 ms after it went up for one that is held.
  constexpr unsigned long pace_ms = 25;
  server_->fake_key(server_->display, code, down ? 1 : 0, down ? pace_ms : 0);
  finish();
}

void VirtualScreen::tap(const std::string& keysym) {
  key(keysym, true);
  key(keysym, false);
}

void VirtualScreen::tapWith(const std::string& modifier, const std::string& keysym) {
  key(modifier, true);
  tap(keysym);
  key(modifier, false);
}

void VirtualScreen::type(const std::string& text) {
  for (const char c : text) {
    if (c == '_')
      tapWith("Shift_L", "underscore");
    else
      tap(c == '.' ? "period" : c == '-' ? "minus" : c == '/' ? "slash" : std::string(1, c));
  }
}

void VirtualScreen::resize(unsigned width, unsigned height) {
  XWindow root = 0, child = 0;
  int x = 0, y = 0, inner_x = 0, inner_y = 0;
  unsigned mask = 0;
  server_->query_pointer(server_->display, server_->root_window(server_->display), &root, &child, &x, &y, &inner_x,
                         &inner_y, &mask);
  if (child != 0) server_->resize_window(server_->display, child, width, height);
  finish();
}

}  // namespace palpate::test
