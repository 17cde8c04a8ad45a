/* A bridge between a haptic device and Palpate: 64-byte packets over UDP (engine/realtime/device/README.md). In place
 * of a vendor's SDK it has a handle that a spring pulls down: replace readHandle and setForce.
 *
 *   cc -O2 udp_device.c -o udp_device -lm && ./udp_device 7711 & palpate layer_sphere --device udp:7711
 */
#include <arpa/inet.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

/* As they go over the line, on a little-endian machine. */
typedef struct {
  char magic[4];
  uint32_t sequence, felt, buttons;
  int64_t ns;
  float position[3], orientation[4], velocity[3];
} pose_packet;
typedef struct {
  char magic[4];
  uint32_t sequence, answers, touching;
  int64_t ns;
  float force[3], torque[3];
  char zero[16];
} force_packet;

static double z = 0, v = 0, pushed = 0; /* the handle, m, m/s, N */

static void readHandle(pose_packet* pose) { /* <- the SDK's position, turn and velocity */
  const double mass = 0.1, down = pose->felt ? 0.012 : 0, spring = 60, damping = 4, dt = 1e-3;
  v += dt / mass * (spring * (-down - z) - damping * v + pushed);
  z += dt * v;
  pose->position[2] = (float)z;
  pose->velocity[2] = (float)v;
  pose->orientation[3] = 1;
}

static void setForce(const float force[3]) { pushed = force[2]; } /* <- the SDK's force; torques likewise */

int main(int argc, char** argv) {
  const int line = socket(AF_INET, SOCK_DGRAM, 0);
  const long steps = argc > 2 ? atol(argv[2]) : -1; /* ms; -1: without end */
  struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(argc > 1 ? atoi(argv[1]) : 7711)};
  struct timespec next;
  pose_packet pose = {.magic = "PLP1"};
  force_packet force;
  long silent = 0;
  _Static_assert(sizeof pose == 64 && sizeof force == 64, "packets have 64 bytes");
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(line, (struct sockaddr*)&to, sizeof to) != 0) return perror("udp_device"), 1;
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (long k = 0; k != steps; ++k) {
    readHandle(&pose);
    ++pose.sequence;
    pose.ns = next.tv_sec * 1000000000LL + next.tv_nsec;
    send(line, &pose, sizeof pose, 0); /* refused while Palpate does not listen: the next may arrive */
    for (++silent; recv(line, &force, sizeof force, MSG_DONTWAIT) == sizeof force;) {
      if (memcmp(force.magic, "PLF1", 4) != 0 || (int32_t)(force.sequence - pose.felt) <= 0) continue;
      pose.felt = force.sequence;
      silent = 0;
      setForce(force.force);
    }
    if (silent > 20) {
      setForce((const float[3]){0, 0, 0});
      pose.felt = 0; /* it may begin anew */
    }
    if (k % 500 == 0) printf("handle %7.2f mm  force %6.3f N\n", 1e3 * z, pushed), fflush(stdout);
    next.tv_nsec += 1000000;
    if (next.tv_nsec >= 1000000000) next.tv_nsec -= 1000000000, ++next.tv_sec;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
  }
  return 0;
}
