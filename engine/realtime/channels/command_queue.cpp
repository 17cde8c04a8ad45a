#include "realtime/channels/command_queue.h"

namespace palpate {

Request Request::goToPlace(const PlaceIndex& place) {
  Request request;
  request.kind = Kind::GoToPlace;
  request.place = place;
  return request;
}

Request Request::simple(Kind kind) {
  Request request;
  request.kind = kind;
  return request;
}

Request Request::moveTool(const Pose& pose, double seconds) {
  Request request = simple(Kind::MoveTool);
  request.pose = pose;
  request.value = seconds;
  return request;
}

Request Request::thenMoveTool(const Pose& pose, double seconds) {
  Request request = moveTool(pose, seconds);
  request.kind = Kind::ThenMoveTool;
  return request;
}

Request Request::steer(const Vec3& velocity, const Vec3& turn, double seconds) {
  Request request = simple(Kind::Steer);
  request.pose.position = velocity;
  request.point = turn;
  request.value = seconds;
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

Request Request::setGravity(const Vec3& acceleration) {
  Request request = simple(Kind::SetGravity);
  request.point = acceleration;
  return request;
}

Request Request::setForce(int skin_vertex, const Vec3& force) {
  Request request = simple(Kind::SetForce);
  request.index = skin_vertex;
  request.point = force;
  return request;
}

Request Request::pin(int skin_vertex, const Vec3& place) {
  Request request = simple(Kind::Pin);
  request.index = skin_vertex;
  request.point = place;
  return request;
}

Request Request::unpin(int skin_vertex) {
  Request request = simple(Kind::Unpin);
  request.index = skin_vertex;
  return request;
}

Request Request::moveRegion(int boundary, const Vec3& shift) {
  Request request = simple(Kind::MoveRegion);
  request.index = boundary;
  request.point = shift;
  return request;
}

Request Request::moveHand(int tool, const Pose& pose) {
  Request request = simple(Kind::MoveHand);
  request.index = tool;
  request.pose = pose;
  return request;
}

Request Request::mark(const Vec3& place, int hardness) {
  Request request = simple(Kind::Mark);
  request.point = place;
  request.index = hardness;
  return request;
}

Request Request::setOpening(int tool, double opening) {
  Request request = simple(Kind::SetOpening);
  request.index = tool;
  request.value = opening;
  return request;
}

}  // namespace palpate
