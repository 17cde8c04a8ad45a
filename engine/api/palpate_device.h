/* A haptic device at a simulation of palpate.h, for whoever links its maker's SDK: pose in, force out, from a thread of
 * yours that runs at about 1 kHz. C99.
 *
 *   palpate_couple(simulation, NULL, &error);                         the scene's [device], or settings of your own
 *   palpate_start(simulation, 0);
 *   each millisecond:  pose from the SDK;  palpate_exchange(simulation, 0, &pose, &wrench);  force to the SDK
 *   palpate_stop(simulation);  palpate_uncouple(simulation);
 *
 * Between handle and tool hangs a spring and a damper. In contact the hand feels
 *
 *   F = stiffness (x_tool - x_device) + damping (v_tool - v_device)
 *
 * and in air nothing, within these bounds:
 *   - |force| <= max_force, and it rises by max_force / rise_time at most; |torque| <= max_force lever, likewise
 *   - stiffness is lowered to what the way's delay allows:  stiffness (T/2 + delay) <= own_damping
 *   - passive: the energy at the handle is counted, and no spring pushes harder than one that holds what the hand has
 *     put in and not got back, and 0.1 mJ; the spring's end slips instead, as a clutch
 *   - a contact only pushes
 *   - dead man: without a pose for 10 ms (or for 2.5 periods of a device of 50 Hz or more; slower ones are silent) the
 *     force goes to 0 within 40 ms; likewise while the tissue is put back, frozen or late. Then the handle takes the
 *     tool again where both are. What it got in between is held against it, until a second without force in air
 *
 * World and device have the same axes: x, z up. Where the handle is when it first takes the tool is the tool's start.
 * While a simulation is coupled its first tool follows the device: palpate_set_target, or a pose given to palpate_step,
 * is PALPATE_REFUSED. A recording or saved state knows nothing of the coupling; after palpate_reset or palpate_restore
 * it takes the tool anew. */
#ifndef PALPATE_DEVICE_H
#define PALPATE_DEVICE_H

#include "palpate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The coupling, as a scene's [device] has it. */
typedef struct palpate_device_settings {
  uint32_t size;      /* sizeof(palpate_device_settings) */
  int32_t locked;     /* 1: the tool keeps the orientation that it starts with, and there is no torque */
  double stiffness;   /* N/m, 10 to 20000: what the device can hold stably, not what the tissue is */
  double damping;     /* N s/m, 0 to 50 */
  double max_force;   /* N, above 0, up to 100 */
  double rise_time;   /* s, 0.001 to 1, from nothing to max_force at the quickest */
  double scale;       /* m of the scene for each m of the device, 0.01 to 100 */
  double own_damping; /* N s/m, 0.05 to 50, of the device and the lightest hand that holds it */
  double lever;       /* m, 0.001 to 0.5: a turn is a way at it, a torque a force at it */
} palpate_device_settings;

/* What a device tells of its handle, in its own frame. */
typedef struct palpate_device_pose {
  uint32_t size;        /* sizeof(palpate_device_pose) */
  uint32_t sequence;    /* counts up from 1; comes back as palpate_state.pose_sequence */
  uint32_t felt;        /* palpate_wrench.sequence of the newest that the motors have; 0: it does not say */
  int32_t has_velocity; /* 0: it is made from poses */
  int64_t sent_ns;      /* by the device's clock, whatever its zero; 0: it has none */
  double pose[7];       /* within 10 m */
  double velocity[3];   /* m/s, at most 100 */
} palpate_device_pose;

/* What to push the handle with, until the next. */
typedef struct palpate_wrench {
  uint32_t size;     /* sizeof(palpate_wrench) */
  int32_t touching;  /* 1: the tool touches the tissue */
  uint32_t sequence; /* counts up from 1 */
  uint32_t answers;  /* palpate_device_pose.sequence */
  double force[3];   /* N, on the handle */
  double torque[3];  /* N m, on the handle */
} palpate_wrench;

/* What a coupling has seen since palpate_couple. */
typedef struct palpate_coupling_state {
  uint32_t size;          /* sizeof(palpate_coupling_state) */
  int32_t engaged;        /* 1: the handle has the tool */
  int64_t poses;          /* that came */
  int64_t silences;       /* times that they stopped coming */
  int64_t fades;          /* times that the tissue was put back, frozen or late */
  double stiffness;       /* N/m, in force */
  double delay_s;         /* there and back: told by `felt` (the second longest of 64), or assumed */
  double energy_J;        /* that the hand has put in and not got back, */
  double lowest_energy_J; /* and the least of it so far: what the coupling has given away where negative */
  double damped_J;        /* taken out again as the spring's end slipped */
  double peak_force;      /* N */
  double peak_torque;     /* N m */
  double slipped_m;       /* that the spring's end is from the handle's place now, in the scene: what stretched it
                             further than the hand had paid for, or a handle that was put elsewhere at once. In air it
                             comes back in 0.3 s; in contact tell the hand to lift off */
} palpate_coupling_state;

/* The scene's settings. */
PALPATE_API int32_t palpate_scene_device(const palpate_model* model, palpate_device_settings* settings);

/* (control, stopped, and no function marked (hand) beside it) The simulation's first tool hangs on a device from now
 * on; one that did already begins anew. PALPATE_BAD_ARGUMENT: the error's text names the setting that is out of range.
 * @param settings  NULL: the scene's */
PALPATE_API int32_t palpate_couple(palpate_simulation* simulation, const palpate_device_settings* settings,
                                   palpate_error* error);

/* (control, stopped, and no function marked (hand) beside it) The tool stays where it is. Does nothing where there is
 * no coupling. */
PALPATE_API int32_t palpate_uncouple(palpate_simulation* simulation);

/* (hand) One exchange with the device: its newest pose in, the force out, the tool's target on to the loop. No
 * allocation or lock. PALPATE_REFUSED where nothing is coupled. A pose that can't be one (not finite, or further than
 * 10 m) counts as none, so that the force fades: PALPATE_BAD_ARGUMENT, and the wrench is to be sent all the same.
 * @param now_ns  CLOCK_MONOTONIC; 0: it is read. A step back counts as no time
 * @param pose    what has come since the last call; NULL: nothing */
PALPATE_API int32_t palpate_exchange(palpate_simulation* simulation, int64_t now_ns, const palpate_device_pose* pose,
                                     palpate_wrench* wrench);

/* (hand) PALPATE_REFUSED where nothing is coupled. */
PALPATE_API int32_t palpate_read_coupling(const palpate_simulation* simulation, palpate_coupling_state* state);

#ifdef __cplusplus
}
#endif

#endif
