// palpate-igtl SCENE: a server of OpenIGTLink (3D Slicer, navigation) around a simulation: a tracked tool in; force,
// deformed surface and volume out. Built on palpate.h alone, where libopenigtlink-dev is installed.
#include <igtlClientSocket.h>
#include <igtlSensorMessage.h>
#include <igtlServerSocket.h>
#include <igtlStringMessage.h>
#include <igtlTimeStamp.h>
#include <igtlUnit.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <thread>

#include "igtl_messages.h"

namespace {

using namespace palpate::igtl_bridge;
using Clock = std::chrono::steady_clock;

constexpr int stop_wait_ms = 100;   // after which a thread that waits for a client looks whether it should end
constexpr int send_wait_ms = 2000;  // a client that takes nothing for so long is gone
constexpr std::uint64_t largest_message = 1 << 24;  // bytes; tools' poses have 48
constexpr std::size_t longest_name = 15;            // of the protocol's 20, with "Felt" before it and a number behind
constexpr int volume_cells = 64;                    // along the body's longest side

std::atomic<bool> stopped = false;
void stop(int) { stopped = true; }

struct Options {
  std::string scene, tool = "Tool";
  int port = 18944;  // that 3D Slicer proposes
  double rate = 20, seconds = 0;
};

/// Of a field of a header, which a zero ends if it is shorter.
std::string textAt(const unsigned char* bytes, std::size_t most) { return {bytes, std::find(bytes, bytes + most, 0)}; }

/// What the library refused, with its reason.
struct Refusal : std::runtime_error {
  Refusal(int32_t why, const std::string& text) : std::runtime_error(text), code(why) {}
  int32_t code;  // PALPATE_BAD_INPUT, ...
};

void require(int32_t code, const palpate_error& error) {
  if (code != PALPATE_OK) throw Refusal(code, error.text[0] ? error.text : palpate_result_text(code));
}

/// A scene that runs at its rate.
class Body {
 public:
  explicit Body(const std::string& scene) {
    palpate_error error{};
    error.size = sizeof error;
    palpate_model* model = nullptr;
    require(palpate_load(scene.c_str(), nullptr, &model, &error), error);
    model_.reset(model);
    palpate_model_info info{};
    info.size = sizeof info;
    require(palpate_describe(model, &info), error);
    require(palpate_tool_count(model, &tools_), error);
    skin_.x.resize(3 * static_cast<std::size_t>(info.skin_vertex_count));
    skin_.corners.resize(3 * static_cast<std::size_t>(info.skin_triangle_count));
    require(palpate_skin_triangles(model, skin_.corners.data(), info.skin_triangle_count), error);
    palpate_simulation* simulation = nullptr;
    require(palpate_create(model, &simulation, &error), error);
    simulation_.reset(simulation);
    require(palpate_start(simulation, 0), error);
  }

  int tools() const { return tools_; }
  /// (hand)
  bool move(int tool, const double* pose) { return palpate_set_tool_target(simulation_.get(), tool, pose, 0) == 0; }
  /// (viewer)
  const Skin& skin() {
    palpate_skin_positions(simulation_.get(), skin_.x.data(), static_cast<int32_t>(skin_.x.size() / 3));
    return skin_;
  }
  palpate_state state() const {
    palpate_state state{};
    state.size = sizeof state;
    palpate_read(simulation_.get(), &state);
    return state;
  }
  palpate_tool_state tool(int number) const {
    palpate_tool_state state{};
    state.size = sizeof state;
    palpate_read_tool(simulation_.get(), number, &state);
    return state;
  }

 private:
  std::unique_ptr<palpate_model, decltype(&palpate_model_destroy)> model_{nullptr, palpate_model_destroy};
  std::unique_ptr<palpate_simulation, decltype(&palpate_destroy)> simulation_{nullptr, palpate_destroy};
  int32_t tools_ = 0;
  Skin skin_;
};

/// One client: a thread takes what it sends, the calling one sends.
class Connection {
 public:
  Connection(igtl::ClientSocket::Pointer socket, igtl::ServerSocket& server, Body& body, const Options& options)
      : socket_(std::move(socket)), server_(server), body_(body), options_(options) {
    socket_->SetReceiveTimeout(stop_wait_ms);
    socket_->SetSendTimeout(send_wait_ms);
  }

  /// Until the client is gone, `end` or a signal.
  void serve(Clock::time_point end) {
    std::jthread receiver([this] { receive(); });
    const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options_.rate));
    for (auto next = Clock::now(); !gone_ && !stopped && next < end; next += period) {
      refuseOthers();
      std::this_thread::sleep_until(next);
      sendAll();
      if (Clock::now() > next + period) next = Clock::now();  // a client that takes less often gets less
    }
    gone_ = true;
  }

 private:
  /// One client at a time. One that waited would be heard when this one has gone, with poses that are long past.
  void refuseOthers() {
    constexpr int at_once_ms = 1;
    const igtl::ClientSocket::Pointer other = server_.WaitForConnection(at_once_ms);
    if (other.IsNull()) return;
    other->CloseSocket();
    std::cerr << "palpate-igtl: another client was refused: one at a time" << std::endl;
  }

  template <class Message>
  void send(const Message& message) {
    auto now = igtl::TimeStamp::New();
    now->GetTime();
    message->SetTimeStamp(now);
    message->Pack();
    if (!socket_->Send(message->GetPackPointer(), message->GetPackSize())) gone_ = true;
  }

  void sendVector(const std::string& name, const double* value, int unit, int further_unit) {
    auto message = igtl::SensorMessage::New();
    auto units = igtl::Unit::New();
    units->Append(unit, 1);
    if (further_unit != 0) units->Append(further_unit, 1);
    message->SetDeviceName(name.c_str());
    message->SetLength(3);
    message->SetUnit(units);
    for (unsigned k = 0; k < 3; ++k) message->SetValue(k, value[k]);
    send(message);
  }

  void sendAll() {
    for (int k = 0; k < body_.tools(); ++k) {
      const palpate_tool_state tool = body_.tool(k);
      const std::string number = k == 0 ? "" : std::to_string(k + 1);
      sendVector("Force" + number, tool.force, igtl::Unit::SI_DERIVED_NEWTON, 0);
      sendVector("Torque" + number, tool.torque, igtl::Unit::SI_DERIVED_NEWTON, igtl::Unit::SI_BASE_METER);
      auto felt = igtl::TransformMessage::New();
      igtl::Matrix4x4 matrix;
      matrixOf(tool.pose, matrix);
      felt->SetDeviceName(("Felt" + options_.tool + number).c_str());
      felt->SetMatrix(matrix);
      send(felt);
    }
    auto trust = igtl::StringMessage::New();
    const std::string doubt = palpate_doubt_text(body_.state().doubt);
    trust->SetDeviceName("Trust");
    trust->SetString(doubt.empty() ? "good" : doubt.c_str());
    send(trust);
    send(surfaceMessage(body_.skin(), "Tissue"));
    if (volume_wanted_.exchange(false)) send(volumeMessage(body_.skin(), volume_cells, "TissueVolume"));
  }

  /// All of `size` bytes; false where the client is gone or the end has come.
  bool take(void* data, int size) {
    for (int taken = 0; taken < size;) {
      if (gone_ || stopped) return false;
      errno = 0;
      const int count = socket_->Receive(static_cast<char*>(data) + taken, size - taken, 0);
      if (count > 0)
        taken += count;
      else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
        return false;
    }
    return true;
  }

  void receive() {
    unsigned char header[header_bytes];
    while (take(header, header_bytes)) {
      const std::uint64_t told = numberAt(header + 42, 8);
      const std::string type = textAt(header + 2, 12), name = textAt(header + 14, 20);
      if (told > largest_message) {
        complain("a message of " + std::to_string(told) + " bytes; the client is let go");
        break;
      }
      std::vector<unsigned char> content(static_cast<std::size_t>(told));
      if (!take(content.data(), static_cast<int>(told))) break;
      if (type == "GET_IMAGE") volume_wanted_ = true;
      if (type != "TRANSFORM") continue;
      igtl::Matrix4x4 matrix;
      std::string problem;
      if (transformOf(header, content, matrix, problem))
        move(matrix, name);
      else
        complain(problem);
    }
    gone_ = true;
  }

  /// "Tool" is the first one, "Tool2" the second; transforms of other names are others' business.
  void move(const igtl::Matrix4x4& matrix, const std::string& name) {
    for (int k = 0; k < body_.tools(); ++k) {
      if (name != options_.tool + (k == 0 ? "" : std::to_string(k + 1))) continue;
      std::string problem;
      const auto pose = poseOf(matrix, problem);
      if (!pose)
        complain(name + ": " + problem);
      else if (!body_.move(k, pose->data()))
        complain(name + ": the pose was refused");
    }
  }

  /// Once for each kind, so that a tracker at 60 Hz does not fill the screen.
  void complain(const std::string& problem) {
    if (problem != last_problem_) std::cerr << "palpate-igtl: left out: " << problem << std::endl;
    last_problem_ = problem;
  }

  igtl::ClientSocket::Pointer socket_;
  igtl::ServerSocket& server_;
  Body& body_;
  const Options& options_;
  std::atomic<bool> gone_ = false, volume_wanted_ = false;
  std::string last_problem_;
};

void run(const Options& options) {
  Body body(options.scene);
  auto server = igtl::ServerSocket::New();
  if (server->CreateServer(options.port) < 0)
    throw std::runtime_error("can't listen on port " + std::to_string(options.port) + "; choose another with --port");
  std::cout << "listening on port " << server->GetServerPort() << std::endl;
  const auto end =
      options.seconds > 0
          ? Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.seconds))
          : Clock::time_point::max();
  while (!stopped && Clock::now() < end) {
    igtl::ClientSocket::Pointer client = server->WaitForConnection(stop_wait_ms);
    if (client.IsNull()) continue;
    std::cout << "a client has come" << std::endl;
    Connection(client, *server, body, options).serve(end);
    client->CloseSocket();
    std::cout << "the client is gone; the tool stays where it is" << std::endl;
  }
  server->CloseSocket();
}

/// As CLI::Range, which takes what is no number.
CLI::Validator within(double low, double high) {
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return {};
        return "a number between " + CLI::detail::to_string(low) + " and " + CLI::detail::to_string(high) + ", please";
      },
      "");
}

std::string isName(const std::string& text) {
  if (!text.empty() && text.size() <= longest_name) return {};
  return "of 1 to " + std::to_string(longest_name) + " letters, please";
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Runs a scene as a server of OpenIGTLink, for 3D Slicer and navigation. In: TRANSFORM \"Tool\" (\"Tool2\", ...), "
      "mm, "
      "tip and axes; GET_IMAGE. Out: SENSOR \"Force\" (N), \"Torque\" (N m), TRANSFORM \"FeltTool\", STRING \"Trust\", "
      "POLYDATA \"Tissue\", and IMAGE \"TissueVolume\" when asked for."};
  app.set_version_flag("--version", std::string(palpate_build()));
  app.add_option("SCENE", options.scene, "Scene file, or the name of one that Palpate brings, e.g. liver")->required();
  app.add_option("--port", options.port, "0: any that is free")->check(CLI::Range(0, 65535))->capture_default_str();
  app.add_option("--rate", options.rate, "Sets of messages per second")->check(within(0.1, 200));
  app.add_option("--tool", options.tool, "Name of the transform that moves the first tool")
      ->check(isName)
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "End after so long; 0: at Ctrl-C")->check(within(0, 1e6));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : (app.exit(error), 2);
  }
  std::signal(SIGPIPE, SIG_IGN);  // a client that has gone is told of by what sending returns
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  try {
    run(options);
  } catch (const Refusal& refusal) {
    std::cerr << "palpate-igtl: " << refusal.what() << std::endl;
    return refusal.code == PALPATE_BAD_INPUT ? 2 : 1;
  } catch (const std::exception& error) {
    std::cerr << "palpate-igtl: " << error.what() << std::endl;
    return 1;
  }
}
