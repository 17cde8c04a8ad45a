#include "app/render/interface.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <stdexcept>

namespace palpate::app {

Interface::Interface(GLFWwindow* window, float scale) : window_(window), context_(ImGui::CreateContext()) {
  ImGui::GetIO().LogFilename = nullptr;
  theme_ = makeTheme(scale);
  const bool ready = (window_ == nullptr || ImGui_ImplGlfw_InitForOpenGL(window_, true)) &&
                     ImGui_ImplOpenGL3_Init("#version 330 core");
  if (!ready) {
    ImGui::DestroyContext(context_);
    throw std::runtime_error("Dear ImGui can't use this OpenGL context");
  }
}

Interface::~Interface() {
  ImGui_ImplOpenGL3_Shutdown();
  if (window_ != nullptr) ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext(context_);
}

void Interface::hold(std::span<const int> codes) {
  ImGuiIO& io = ImGui::GetIO();
  for (const int code : codes) {
    if (code < 0 || code >= IM_ARRAYSIZE(io.KeysDown) || io.KeysDown[code]) continue;
    io.KeysDown[code] = true;
    held_.push_back(code);
  }
}

void Interface::begin(int width, int height) {
  ImGui_ImplOpenGL3_NewFrame();
  if (window_ != nullptr) {
    ImGui_ImplGlfw_NewFrame();
  } else {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
    io.DeltaTime = 1.0F / 60;  // nothing off-screen moves with the clock
    io.MousePos = {-1e6F, -1e6F};
  }
  ImGui::NewFrame();
}

void Interface::end() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  for (const int code : held_) ImGui::GetIO().KeysDown[code] = false;
  held_.clear();
}

}  // namespace palpate::app
