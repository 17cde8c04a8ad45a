#include <fcntl.h>
#include <igtlClientSocket.h>
#include <igtlMessageHeader.h>
#include <igtlSensorMessage.h>
#include <igtlStringMessage.h>
#include <igtl_util.h>
#include <palpate.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "igtl/igtl_messages.h"
#include "io/text_file.h"
#include "support/temp_folder.h"

#ifdef __SANITIZE_ADDRESS__
/// What the library itself (1.11) loses when it unpacks a surface.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:igtl_polydata_alloc_info\n"; }
#endif

using namespace palpate;
using namespace palpate::igtl_bridge;

namespace {

constexpr auto patience = std::chrono::seconds(120);  // on a busy machine; nothing is measured
constexpr const char* scene = "layer_sphere";

template <class Condition>
bool waitFor(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// The bridge as a process, on a port that was free.
class Bridge {
 public:
  Bridge() : log_(folder_.path("log")) {
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that is ended leaves no server
      if (::getppid() != parent) ::_exit(127);
      const int file = ::open(log_.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
      ::dup2(file, 1);
      ::dup2(file, 2);
      ::execl(PALPATE_IGTL_BRIDGE, "palpate-igtl", scene, "--port", "0", "--rate", "50", nullptr);
      ::_exit(127);
    }
    const bool listens = waitFor([&] { return says("listening on port "); });
    if (!listens) end();  // there will be no destructor
    REQUIRE(listens);
    const std::string text = readWholeFile(log_);
    port = std::stoi(text.substr(text.find("port ") + 5));
  }
  ~Bridge() {
    if (!end()) FAIL_CHECK("the bridge did not end well when it was asked to: " << readWholeFile(log_));
  }
  bool says(const std::string& text) const {
    return ::access(log_.c_str(), R_OK) == 0 && readWholeFile(log_).find(text) != std::string::npos;
  }
  int port = 0;

 private:
  /// @return whether it went by itself, and had nothing to complain of
  bool end() {
    int status = 0;
    ::kill(process_, SIGTERM);
    if (waitFor([&] { return ::waitpid(process_, &status, WNOHANG) != 0; })) return status == 0;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    return false;
  }

  TempFolder folder_;
  std::string log_;
  pid_t process_ = 0;
};

/// What 3D Slicer's side does.
class Client {
 public:
  explicit Client(int port) {
    REQUIRE(socket->ConnectToServer("127.0.0.1", port) == 0);
    socket->SetReceiveTimeout(static_cast<int>(std::chrono::milliseconds(patience).count()));
  }
  ~Client() { socket->CloseSocket(); }

  void moveTool(const igtl::Matrix4x4& matrix) {
    auto message = igtl::TransformMessage::New();
    igtl::Matrix4x4 copy;
    std::copy(&matrix[0][0], &matrix[0][0] + 16, &copy[0][0]);
    message->SetDeviceName("Tool");
    message->SetMatrix(copy);
    message->Pack();
    REQUIRE(socket->Send(message->GetPackPointer(), message->GetPackSize()));
  }

  /// The server lets go, after what it has sent before.
  bool isLetGo() {
    char bytes[4096];
    const auto end = std::chrono::steady_clock::now() + patience;
    do {
      errno = 0;
      if (socket->Receive(bytes, sizeof bytes, 0) <= 0) return errno != EAGAIN && errno != EWOULDBLOCK;
    } while (std::chrono::steady_clock::now() < end);
    return false;
  }

  /// The next message of this name, of those that come.
  template <class Message>
  typename Message::Pointer next(const std::string& name) {
    auto header = igtl::MessageHeader::New();
    for (;;) {
      header->InitPack();
      REQUIRE(socket->Receive(header->GetPackPointer(), header->GetPackSize()) == header->GetPackSize());
      header->Unpack();
      if (header->GetDeviceName() != name) {
        socket->Skip(header->GetBodySizeToRead());
        continue;
      }
      auto message = Message::New();
      message->SetMessageHeader(header);
      message->AllocatePack();
      socket->Receive(message->GetPackBodyPointer(), message->GetPackBodySize());
      REQUIRE((message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY));
      return message;
    }
  }

  igtl::ClientSocket::Pointer socket = igtl::ClientSocket::New();
};

/// The scene, and its force where the tool is `depth` m past first touch, at rest.
struct Pressed {
  explicit Pressed(double depth) {
    palpate_model* model = nullptr;
    palpate_simulation* simulation = nullptr;
    info.size = sizeof info;
    state.size = sizeof state;
    REQUIRE(palpate_load(scene, nullptr, &model, nullptr) == PALPATE_OK);
    REQUIRE(palpate_describe(model, &info) == PALPATE_OK);
    REQUIRE(palpate_create(model, &simulation, nullptr) == PALPATE_OK);
    std::copy_n(info.tool_start, 7, pose);
    pose[2] -= info.first_contact_travel + depth;  // the tool's own axis is +z
    REQUIRE(palpate_step(simulation, 1500, pose, &state) == PALPATE_OK);
    palpate_destroy(simulation);
    palpate_model_destroy(model);
  }
  palpate_model_info info{};
  palpate_state state{};
  double pose[7];
};

}  // namespace

TEST_CASE("A client of OpenIGTLink moves the tool, and gets force, surface and volume", "[igtl]") {
  const Pressed pressed(0.0015);
  const Bridge bridge;
  Client client(bridge.port);
  const auto rest = client.next<igtl::PolyDataMessage>("Tissue");
  REQUIRE(rest->GetPoints()->GetNumberOfPoints() == pressed.info.skin_vertex_count);
  REQUIRE(static_cast<int>(rest->GetPolygons()->GetNumberOfCells()) == pressed.info.skin_triangle_count);

  igtl::Matrix4x4 matrix;
  matrixOf(pressed.pose, matrix);
  client.moveTool(matrix);
  double force = 0;
  CHECK(waitFor([&] {
    const auto sensor = client.next<igtl::SensorMessage>("Force");
    REQUIRE(sensor->GetLength() == 3);
    force = sensor->GetValue(2);
    return std::abs(force - pressed.state.force[2]) < 0.005 * pressed.state.force[2];  // at rest but for creep
  }));
  CHECK(pressed.state.force[2] > 0.02);
  const auto felt = client.next<igtl::TransformMessage>("FeltTool");
  igtl::Matrix4x4 back;
  felt->GetMatrix(back);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) CHECK(back[r][c] == Approx(matrix[r][c]).margin(1e-3));
  CHECK(waitFor([&] {  // how exact the force is, is known some tenths of a second later
    const std::string trust = client.next<igtl::StringMessage>("Trust")->GetString();
    return trust == (pressed.state.doubt == 0 ? "good" : palpate_doubt_text(pressed.state.doubt));
  }));

  const auto now = client.next<igtl::PolyDataMessage>("Tissue");
  float deepest = 0;
  for (int v = 0; v < now->GetPoints()->GetNumberOfPoints(); ++v) {
    float a[3], b[3];
    rest->GetPoints()->GetPoint(static_cast<unsigned>(v), a);
    now->GetPoints()->GetPoint(static_cast<unsigned>(v), b);
    deepest = std::max(deepest, a[2] - b[2]);
  }
  CHECK(deepest == Approx(1.5).epsilon(0.1));  // mm

  auto request = igtl::GetImageMessage::New();
  request->SetDeviceName("TissueVolume");
  request->Pack();
  REQUIRE(client.socket->Send(request->GetPackPointer(), request->GetPackSize()));
  const auto volume = client.next<igtl::ImageMessage>("TissueVolume");
  int size[3];
  volume->GetDimensions(size);
  CHECK(std::max({size[0], size[1], size[2]}) == 64);
}

TEST_CASE("What is no pose is left out and told - a client that sends nonsense is let go, the next one served",
          "[igtl]") {
  const Bridge bridge;
  const auto still = [](Client& client) { return client.next<igtl::SensorMessage>("Force")->GetValue(2) == 0; };
  {
    Client client(bridge.port);
    igtl::Matrix4x4 matrix;
    igtl::IdentityMatrix(matrix);
    matrix[0][0] = 2;
    client.moveTool(matrix);
    CHECK(waitFor([&] { return bridge.says("no rigid motion") && still(client); }));
    matrix[0][0] = std::numeric_limits<float>::quiet_NaN();
    client.moveTool(matrix);
    CHECK(waitFor([&] { return bridge.says("not finite") && still(client); }));
    auto message = igtl::TransformMessage::New();  // a matrix that is cut short, and says so
    message->SetDeviceName("Tool");
    message->Pack();
    auto* bytes = static_cast<unsigned char*>(message->GetPackPointer());
    constexpr int header = 58, body = 46;
    bytes[49] = body;
    const std::uint64_t sum = crc64(bytes + header, body, 0);
    for (int k = 0; k < 8; ++k) bytes[50 + k] = static_cast<unsigned char>(sum >> (56 - 8 * k));
    client.socket->Send(bytes, header + body);
    CHECK(waitFor([&] { return bridge.says("a TRANSFORM of 46 bytes") && still(client); }));
    CHECK(Client(bridge.port).isLetGo());
    CHECK(waitFor([&] { return bridge.says("another client was refused") && still(client); }));
    std::string noise(4096, '\xff');
    client.socket->Send(noise.data(), static_cast<int>(noise.size()));
    CHECK(client.isLetGo());
    CHECK(waitFor([&] { return bridge.says("bytes; the client is let go"); }));
  }
  Client next(bridge.port);
  CHECK(still(next));
}

TEST_CASE("Poses go to matrices and back - a volume has the voxels that are inside", "[igtl]") {
  const double pose[7] = {0.01, -0.02, 0.3, 0.5, -0.5, 0.5, 0.5};
  igtl::Matrix4x4 matrix;
  matrixOf(pose, matrix);
  std::string problem;
  const auto back = poseOf(matrix, problem);
  REQUIRE(back);
  for (std::size_t k = 0; k < 7; ++k) CHECK((*back)[k] == Approx(pose[k]).margin(1e-8));

  // As messages of protocol 1 bring it, and of protocol 2: a header of 12 bytes before it, 3 of metadata behind.
  auto message = igtl::TransformMessage::New();
  message->SetMatrix(matrix);
  message->Pack();
  auto* header = static_cast<unsigned char*>(message->GetPackPointer());
  std::vector<unsigned char> body(header + 58, header + 58 + 48);
  const auto read = [&] {
    const std::uint64_t sum = crc64(body.data(), body.size(), 0);
    for (int k = 0; k < 8; ++k) header[50 + k] = static_cast<unsigned char>(sum >> (56 - 8 * k));
    igtl::Matrix4x4 got;
    if (!transformOf(header, body, got, problem)) return false;
    return std::equal(&got[0][0], &got[0][0] + 16, &matrix[0][0]);
  };
  CHECK(read());
  header[1] = 2;
  CHECK_FALSE(read());
  const unsigned char extension[12] = {0, 12, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0};
  body.insert(body.begin(), extension, extension + 12);
  body.insert(body.end(), {1, 2, 3});
  CHECK(read());
  body.pop_back();
  CHECK_FALSE(read());
  CHECK(problem == "a TRANSFORM of 62 bytes");

  matrix[0][0] = -matrix[0][0], matrix[1][0] = -matrix[1][0], matrix[2][0] = -matrix[2][0];
  CHECK_FALSE(poseOf(matrix, problem));

  // The corner of a cube of 0.1 m.
  Skin skin{{0, 0, 0, 0.1F, 0, 0, 0, 0.1F, 0, 0, 0, 0.1F}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
  const auto image = volumeMessage(skin, 50, "volume");
  int size[3];
  float h[3];
  image->GetDimensions(size);
  image->GetSpacing(h);
  CHECK((size[0] == 50 && size[1] == 50 && size[2] == 50));
  CHECK(h[0] == Approx(2.0F));
  const auto* voxel = static_cast<const igtlUint8*>(image->GetScalarPointer());
  int inside = 0;
  for (int k = 0; k < 50; ++k)
    for (int j = 0; j < 50; ++j)
      for (int i = 0; i < 50; ++i, ++voxel) {
        const bool within = i + j + k + 1.5 < 50;  // of centres, in voxels: x + y + z < 0.1 m
        if (std::abs(i + j + k + 1.5 - 50) > 0.1) CHECK(*voxel == within);
        inside += *voxel;
      }
  CHECK(inside * 8e-9 == Approx(0.001 / 6).epsilon(0.05));
}
