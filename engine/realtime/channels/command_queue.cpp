#include "realtime/channels/command_queue.h"

namespace palpate {

Request Request::simple(Kind kind) {
  Request request;
  request.kind = kind;
  return request;
}

Request Request::moveTool(const Pose& pose) {
  Request request = simple(Kind::MoveTool);
  request.pose = pose;
  return request;
}

Request Request::pull(int skin_vertex, const Vec3& target) {
  Request request = simple(Kind::Pull);
  request.index = skin_vertex;
  request.point = target;
  return request;
}

Request Request::setFriction(double coefficient) {
  Request request = simple(Kind::SetFriction);
  request.value = coefficient;
  return request;
}

Request Request::setMaterial(int index, const Material& material) {
  Request request = simple(Kind::SetMaterial);
  request.index = index;
  request.material = material;
  return request;
}

}  // namespace palpate
