/* Palpate as a library: soft tissue under a tool, in real time or step by step. C99; nothing else crosses this border.
 *
 *   model        a scene made ready to run; never changes, and many simulations may share it
 *   simulation   one body's state, advanced by palpate_step on your thread or, between palpate_start and
 *                palpate_stop, at the scene's rate on a thread of its own
 *
 * Lengths are m, forces N, times s, angles rad. A pose is 7 doubles: x, y, z of the tool's tip (within 1e6), then the
 * quaternion x, y, z, w that turns the tool's frame into the world's (normalized where it is not; a norm of half or
 * less, or of two or more, is refused). The tool's own axis is +z, from the tip into the handle.
 *
 * Structs begin with their size: set it to sizeof before a call. A library that knows more fields than you fills those
 * that you know; one that knows fewer leaves yours at 0.
 *
 * Functions return PALPATE_OK or why not; palpate_last_error has it in words. None prints, exits, throws or keeps a
 * pointer of yours. A NULL where something must be is PALPATE_BAD_ARGUMENT.
 *
 * Threads: models may be used by any number of threads. Each function of a simulation says who may call it:
 *   (control)  one thread at a time, and none while another is in a function marked (control)
 *   (hand)     one thread at a time; may run beside all others
 *   (viewer)   likewise
 *   (any)      any number of threads at any time
 * palpate_destroy must be the last.
 *
 * Processes: after a fork the child may use the parent's models and make simulations of its own. Its copies of the
 * parent's simulations have no threads: those that did not run can be stepped, but palpate_start is PALPATE_REFUSED
 * where the scene asks for several. palpate_destroy leaves them alone there.
 */
#ifndef PALPATE_H
#define PALPATE_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define PALPATE_API __attribute__((visibility("default")))
#else
#define PALPATE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct palpate_model palpate_model;
typedef struct palpate_simulation palpate_simulation;
typedef struct palpate_team palpate_team;
typedef struct palpate_points palpate_points;
typedef struct palpate_equilibrium palpate_equilibrium;

/* Outcomes. */
enum {
  PALPATE_OK = 0,
  PALPATE_BAD_ARGUMENT = 1, /* NULL, not finite, out of range, or of a size that the library does not know */
  PALPATE_BAD_INPUT = 2,    /* a scene or script can't be used; the error's text has file:line:column */
  PALPATE_REFUSED = 3,      /* asked properly, but not possible; nothing has changed */
  PALPATE_BUSY = 4,         /* not while the simulation runs on its own thread: palpate_stop first */
  PALPATE_FAILED = 5        /* the system: no memory, no threads, an unreadable file */
};

/* Why a call was not done. Where a function takes one it may be NULL. */
typedef struct palpate_error {
  uint32_t size; /* sizeof(palpate_error) */
  int32_t code;  /* as returned */
  char text[1016];
} palpate_error;

typedef struct palpate_options {
  uint32_t size;            /* sizeof(palpate_options) */
  int32_t threads;          /* physics threads of each simulation, its own one included; 0: the scene's. No result
                               depends on it */
  double rate_hz;           /* ticks per second; 0: the scene's */
  const char* cache_folder; /* where set-ups are kept for the next time, made if need be; NULL: nowhere */
  int (*progress)(void* user, const char* what, double fraction); /* called by the loading thread; not 0: give up */
  void* user;
  const char* const* set; /* keys of the scene that get other values, as TOML writes them: "material[0].young = 4000" */
  int32_t set_count;
} palpate_options;

typedef struct palpate_model_info {
  uint32_t size; /* sizeof(palpate_model_info) */
  int32_t node_count, point_count;
  int32_t skin_vertex_count, skin_triangle_count;
  int32_t material_count;
  double rate_hz;              /* a tick is 1 / rate_hz */
  double tool_start[7];        /* pose */
  double tool_radius;          /* m */
  double first_contact_travel; /* m from the start along the tool's axis to the resting skin; 0 where the tool touches
                                  it at the start, and where it never meets it that way */
  uint64_t hash;               /* of all that decides a run but its input */
} palpate_model_info;

/* Why the force should not be believed, the gravest that applies: palpate_state.doubt. */
enum {
  PALPATE_DOUBT_NONE = 0,
  PALPATE_DOUBT_VOLUME = 1,
  PALPATE_DOUBT_CONTACT = 2,
  PALPATE_DOUBT_SQUEEZED = 3,
  PALPATE_DOUBT_STEP = 4,
  PALPATE_DOUBT_ENERGY = 5,
  PALPATE_DOUBT_INVERTED = 6,
  PALPATE_DOUBT_LOST = 7,
  PALPATE_DOUBT_RESOLUTION = 8 /* the least of all: the nodes are too far apart, or mass_scaling slows the motion */
};

/* One tick's outcome. */
typedef struct palpate_state {
  uint32_t size;            /* sizeof(palpate_state) */
  int32_t doubt;            /* PALPATE_DOUBT_...; palpate_doubt_text says what to do */
  int32_t fresh;            /* 1: young enough for a hand (10 ms, or three periods of a slower loop); else fade out */
  int32_t frozen;           /* 1: the tissue was lost too often and stands still; palpate_reset */
  int32_t contact_count;    /* points of the skin that carry force, of the first tool */
  int32_t loss_count;       /* times that the solution was lost, and the tissue went back to an earlier state */
  int64_t tick;             /* ticks since create, or since a reset while stopped; 0: none yet */
  uint64_t pose_sequence;   /* of the pose that this answers, as given to palpate_set_target; those that palpate_step
                               is given are counted from 1 on by themselves */
  double time_s;            /* tick / rate */
  double age_s;             /* wall time since the tick began that computed this */
  double pose[7];           /* of the tool that the tissue felt: it may yield, or lag behind a fast hand */
  double force[3];          /* N, on the tool, as computed */
  double force_filtered[3]; /* N, low-passed ([force] cutoff of the scene), for a display */
  double torque[3];         /* N m, on the tool about its tip, as computed; expected_error does not speak of it */
  double normal[3];         /* unit, from the tissue towards the tool; 0: no contact */
  double stiffness;         /* N/m, of late, force over travel along the normal (50 ms); 0: not known */
  double depth_m;           /* how far the tool's foremost point along the skin's normal is beyond where the skin
                               lay at rest there; on a slope that is more than its tip. Negative: the gap; 0 where
                               nothing touches but the skin lay there at rest */
  double advance_m;         /* travel along the tool's first axis past first touch, or past the start where the tool
                               meets no skin that way */
  double work_J;            /* that the tool has done on the tissue */
  double expected_error;    /* of forces, as a share, because the scene's cloud is no finer: 0.05 is 5 % off. Of
                               several tools, or round rigid bodies, that press, of what is worst off; where none
                               does, of what strains the tissue otherwise (loads, other organs), or pressed last. An
                               estimate of some tenths of a second ago; 1 while something is touched and there is
                               none yet (tenths of a second after a touch and after a restore), with doubt
                               "resolution" */
} palpate_state;

/* A parameter of a material's law, by the name that scenes give it: "young", "poisson", "mu". */
typedef struct palpate_parameter {
  const char* name;
  const double* values; /* as many as the law takes: one, or a list's */
  int32_t count;
} palpate_parameter;

/* One tool's part of a tick's outcome, in a scene that has several, or jaws. */
typedef struct palpate_tool_state {
  uint32_t size;         /* sizeof(palpate_tool_state) */
  int32_t contact_count; /* points of the skin that carry force */
  int64_t tick;          /* as palpate_state.tick */
  double pose[7];        /* of the tool that the tissue felt; of jaws, of the middle between their tips */
  double force[3];       /* N, on the tool; jaws: both fingers' */
  double torque[3];      /* N m, on the tool about its tip */
  double opening;        /* m, of jaws: the gap between their fingers; else 0 */
  double pinch;          /* N, of jaws: mean of what presses the two fingers apart; else 0 */
  double expected_error; /* of this tool's force, as palpate_state's, which is the worst tool's; 1: not known yet. Of
                            jaws it is a share of the larger of force and pinch */
} palpate_tool_state;

/* ---- Library ---- */

/* "0.2.0". */
PALPATE_API const char* palpate_version(void);

/* One line for reports: version, compiler, instruction set. */
PALPATE_API const char* palpate_build(void);

/* A sentence for an outcome, or for a palpate_state.doubt ("" for none). */
PALPATE_API const char* palpate_result_text(int32_t code);
PALPATE_API const char* palpate_doubt_text(int32_t doubt);

/* Why the calling thread's last call that was not done was not: "vertex is 5000, not below 2000". "": none failed. It
 * stays until another one fails. */
PALPATE_API const char* palpate_last_error(void);

/* For libraries beside this one, as libpalpate_image: keeps `text` as why a call of this thread was not done. Returns
 * `code`. */
PALPATE_API int32_t palpate_keep_error(int32_t code, const char* text);

/* ---- Model ---- */

/* Makes a model from a scene file, or from the name of a scene that the library brings. Takes seconds.
 * Where the scene's cloud follows the tool ([discretization] follow) its simulations make nodes around the tool while
 * they run: palpate_step waits for them (a second at new places, less from options.cache_folder), so that its bits are
 * those of `palpate --fast`; palpate_start does not, and goes on with the nodes that it has. palpate_describe counts
 * the nodes of the start, palpate_points_of gives them, palpate_settle has those for its pose.
 * PALPATE_REFUSED: stepping in a process that was forked off after palpate_create.
 * @param options  NULL: the scene's own
 * @param model    receives it; NULL where it fails */
PALPATE_API int32_t palpate_load(const char* scene, const palpate_options* options, palpate_model** model,
                                 palpate_error* error);

/* The same from a text in memory, which is TOML as scene files are.
 * @param folder  that the scene's relative paths start from; NULL: the working directory
 * @param name    what errors call it; NULL: "scene text" */
PALPATE_API int32_t palpate_load_text(const char* text, const char* folder, const char* name,
                                      const palpate_options* options, palpate_model** model, palpate_error* error);

/* Simulations that use it live on. NULL does nothing. */
PALPATE_API void palpate_model_destroy(palpate_model* model);

/* How many tools the scene has; those beside the first have the numbers 1, 2, ...
 * @param count  receives it */
PALPATE_API int32_t palpate_tool_count(const palpate_model* model, int32_t* count);

PALPATE_API int32_t palpate_describe(const palpate_model* model, palpate_model_info* info);

/* What a scene has several of, by number: materials and regions by the names that it gives them, else "material 1",
 * "fixed 1"; tools by their shape, "sphere" or "jaws", and "sphere 1", "sphere 2" where there are several. Regions are
 * those that are fixed, and after them those that are prescribed; rigid bodies are those of [[rigid]], or the [skull].
 * palpate_name: NULL where there is none; lives as long as the model. palpate_index: the first of that name, or -1. */
enum { PALPATE_MATERIAL = 0, PALPATE_TOOL = 1, PALPATE_REGION = 2, PALPATE_RIGID = 3 };
PALPATE_API int32_t palpate_count(const palpate_model* model, int32_t kind, int32_t* count);
PALPATE_API const char* palpate_name(const palpate_model* model, int32_t kind, int32_t index);
PALPATE_API int32_t palpate_index(const palpate_model* model, int32_t kind, const char* name);

/* Corners of the skin's triangles, counter-clockwise from outside.
 * @param corners  (triangle_count, 3), indices of skin vertices
 * @param triangle_count  as palpate_describe says */
PALPATE_API int32_t palpate_skin_triangles(const palpate_model* model, int32_t* corners, int32_t triangle_count);

/* The poses of a tool script, one for the end of each tick.
 * @param script    a file, or the name of a script that the library brings; NULL or "": the indentation of an
 *                  off-screen run
 * @param poses     (capacity, 7); NULL with capacity 0: only counts
 * @param count     receives how many there are, also where capacity is less: then the first ones are written */
PALPATE_API int32_t palpate_script(const palpate_model* model, const char* script, double* poses, int64_t capacity,
                                   int64_t* count, palpate_error* error);
/* How far the script has the first tool's jaws open, m, in each of these ticks: for palpate_set_opening before the
 * step. None (count 0) where that tool is no jaws. */
PALPATE_API int32_t palpate_script_openings(const palpate_model* model, const char* script, double* openings,
                                            int64_t capacity, int64_t* count, palpate_error* error);

/* ---- Simulation ---- */

/* The body at rest and the tool at its start. Takes all memory, and starts the physics threads. */
PALPATE_API int32_t palpate_create(const palpate_model* model, palpate_simulation** simulation, palpate_error* error);

/* Stops it where it runs. NULL does nothing. */
PALPATE_API void palpate_destroy(palpate_simulation* simulation);

/* (control; acts as hand, too) n ticks on the calling thread, as fast as it can: bit for bit what the loop does. The
 * tool goes to `pose` in the first of them, or as far as the scene's max_speed lets it, and stays.
 * @param n      0: takes the pose only, for the next tick
 * @param pose   (7); NULL: as before
 * @param state  receives the last tick's outcome; may be NULL */
PALPATE_API int32_t palpate_step(palpate_simulation* simulation, int64_t n, const double* pose, palpate_state* state);

/* Threads that step simulations side by side. NULL does nothing in destroy, and is the calling thread in step_many.
 * @param threads  the calling one included, at most 64; 0: one for each core that the process may use */
PALPATE_API int32_t palpate_team_create(int32_t threads, palpate_team** team, palpate_error* error);
PALPATE_API void palpate_team_destroy(palpate_team* team);

/* (control, of the team and of all of its simulations) palpate_step for many, of one model or several: the bits are
 * those of one after the other. What is refused is so before any has moved, and the error's text says which it is.
 * @param simulations  (count) none of them twice; scenes with one thread each share the cores best
 * @param poses        (count, 7); NULL: as before
 * @param states       (count), all of one size; may be NULL */
PALPATE_API int32_t palpate_step_many(palpate_team* team, palpate_simulation* const* simulations, int32_t count,
                                      int64_t n, const double* poses, palpate_state* states, palpate_error* error);

enum { PALPATE_ORDINARY_THREAD = 1 };

/* (control) The simulation goes on by itself, at the scene's rate, on a thread of its own. It asks the system for
 * real-time scheduling and locked memory, and does without where they are refused.
 * @param flags  PALPATE_ORDINARY_THREAD: asks the system for nothing */
PALPATE_API int32_t palpate_start(palpate_simulation* simulation, uint32_t flags);

/* (control) Ends that thread after its present tick, and waits for it. It may be started, or stepped, again. */
PALPATE_API int32_t palpate_stop(palpate_simulation* simulation);

/* (hand) Where the tool should be: the latest wins, and nothing smooths it. Wait-free: no allocation, lock or system
 * call.
 * @param pose      (7)
 * @param sequence  comes back as palpate_state.pose_sequence */
PALPATE_API int32_t palpate_set_target(palpate_simulation* simulation, const double* pose, uint64_t sequence);

/* (any) The newest tick's outcome. Lock-free: no allocation or lock. */
PALPATE_API int32_t palpate_read(const palpate_simulation* simulation, palpate_state* state);

/* (hand, a thread for each tool) As palpate_set_target, for any of the scene's tools. One that its scene's script moves
 * is taken over. The sequence comes back for tool 0 only. PALPATE_BAD_ARGUMENT where there is no such tool.
 * @param tool  0 to palpate_tool_count - 1 */
PALPATE_API int32_t palpate_set_tool_target(palpate_simulation* simulation, int32_t tool, const double* pose,
                                            uint64_t sequence);

/* (hand, a thread for each tool) How far the jaws of a tool should be open, from the next tick on; they go there as
 * fast as the scene lets them, and stop where they pinch with its grip_force. The latest wins. PALPATE_BAD_ARGUMENT
 * where that tool is no jaws.
 * @param opening  m, the gap between the fingers, at least 0 */
PALPATE_API int32_t palpate_set_opening(palpate_simulation* simulation, int32_t tool, double opening);

/* (any) One tool's part of the newest tick. Lock-free: no allocation or lock. */
PALPATE_API int32_t palpate_read_tool(const palpate_simulation* simulation, int32_t tool, palpate_tool_state* state);

/* (viewer) Where the skin is in the newest tick. No allocation or lock.
 * @param positions     (vertex_count, 3) m
 * @param vertex_count  as palpate_describe says */
PALPATE_API int32_t palpate_skin_positions(palpate_simulation* simulation, float* positions, int32_t vertex_count);

/* (viewer) The forces on the tissue in the newest tick, by skin vertex. They sum to minus the force on all tools; a
 * vertex may come more than once.
 * @param vertex  (capacity)
 * @param force   (capacity, 3) N
 * @param count   receives how many there are, also where capacity is less: then the first ones are written */
PALPATE_API int32_t palpate_contacts(palpate_simulation* simulation, int32_t* vertex, float* force, int32_t capacity,
                                     int32_t* count);

/* A place on the skin. */
typedef struct palpate_skin_point {
  uint32_t size;         /* sizeof(palpate_skin_point) */
  int32_t triangle;      /* as of palpate_skin_triangles; -1: there is none, and all else is 0 */
  double distance;       /* m; of palpate_closest negative inside the body */
  double point[3];       /* m */
  double normal[3];      /* unit, outward, of the triangle */
  double barycentric[3]; /* weights of its corners */
} palpate_skin_point;

/* (viewer) The place of the skin, as it is in the newest tick, that is closest to x, m (3), or that a ray meets first,
 * from either side. The first question after a tick takes ms (it sorts the triangles), further ones us. */
PALPATE_API int32_t palpate_closest(palpate_simulation* simulation, const double* x, palpate_skin_point* place);
PALPATE_API int32_t palpate_ray(palpate_simulation* simulation, const double* origin, const double* direction,
                                palpate_skin_point* place);

/* (control, stopped) Where tools touch the skin, point by point. Each array may be NULL.
 * @param position  (capacity, 3) m
 * @param normal    (capacity, 3) unit, from the tissue towards the tool
 * @param force     (capacity, 3) N, on the tissue
 * @param tool      (capacity) its number
 * @param count     as of palpate_contacts */
PALPATE_API int32_t palpate_contact_points(const palpate_simulation* simulation, double* position, double* normal,
                                           double* force, int32_t* tool, int32_t capacity, int32_t* count);

/* (control, stopped) What holds the tissue at each region, N and N m about the region's axis (the origin where it has
 * none), in the last step; 0 before the first, and after a reset or restore.
 * @param force, moment  (region_count, 3), on the tissue; may be NULL
 * @param region_count   as palpate_count says of PALPATE_REGION */
PALPATE_API int32_t palpate_reactions(const palpate_simulation* simulation, double* force, double* moment,
                                      int32_t region_count);

/* (viewer) What each rigid body presses the tissue with in the newest tick, N; 0 before the first, and after a reset;
 * after a restore that of the saved state.
 * @param force        (rigid_count, 3), on the tissue
 * @param rigid_count  as palpate_count says of PALPATE_RIGID */
PALPATE_API int32_t palpate_rigid_forces(palpate_simulation* simulation, double* force, int32_t rigid_count);

/* ---- Points of the body ---- */

enum { PALPATE_NODES = 0, PALPATE_INTEGRATION_POINTS = 1 };

/* Material points of which fields are asked, made once for all simulations of a model, and used by any threads. Given
 * ones, or a model's own in its order. PALPATE_BAD_ARGUMENT names the first that is not in the body, nor within a
 * twentieth of the nodes' spacing.
 * @param X      (count, 3) m, where they are at rest
 * @param count  where they are asked for: as many as there are */
PALPATE_API int32_t palpate_points_create(const palpate_model* model, const double* X, int32_t count,
                                          palpate_points** points, palpate_error* error);
PALPATE_API int32_t palpate_points_of(const palpate_model* model, int32_t kind, palpate_points** points,
                                      palpate_error* error);
PALPATE_API void palpate_points_destroy(palpate_points* points);

/* Where they are at rest, m (count, 3), and, of integration points only, what they stand for, m^3 (count). Either may
 * be NULL. */
PALPATE_API int32_t palpate_points_rest(const palpate_points* points, double* X, double* volume, int32_t count);

/* (viewer) Displacements in the newest tick, m (count, 3). No allocation or lock. */
PALPATE_API int32_t palpate_displacements(palpate_simulation* simulation, const palpate_points* points, double* u,
                                          int32_t count);

/* (control, stopped) Velocities in the last step, m/s (count, 3). */
PALPATE_API int32_t palpate_velocities(const palpate_simulation* simulation, const palpate_points* points, double* v,
                                       int32_t count);

/* (control, stopped) Cauchy stresses, Pa (count, 3, 3), and volumes over those at rest (count), with the materials in
 * force: those of the integration point that is nearest at rest. Either may be NULL. */
PALPATE_API int32_t palpate_stresses(const palpate_simulation* simulation, const palpate_points* points, double* stress,
                                     double* J, int32_t count);

/* (control) Coulomb coefficient between the first tool, or another (0: the first), and the tissue, 0 to 2, from the
 * next tick on. */
PALPATE_API int32_t palpate_set_friction(palpate_simulation* simulation, double coefficient);
PALPATE_API int32_t palpate_set_tool_friction(palpate_simulation* simulation, int32_t tool, double coefficient);

/* (control) Parameters of a material, from the next tick on; those not named stay. What is made for the materials as
 * they were loaded (contact's layer, node patches) stays, too: far from them forces are some per cent off those of a
 * scene that has such materials. What has relaxed goes with the shear modulus, as if the tissue had been so before;
 * another share of it follows in its own time. PALPATE_REFUSED: another density, or stiffer than the time step is
 * stable for.
 * @param material  0 to material_count - 1, in the scene's order */
PALPATE_API int32_t palpate_set_material(palpate_simulation* simulation, int32_t material,
                                         const palpate_parameter* parameters, int32_t parameter_count,
                                         palpate_error* error);

/* (control) The index-th parameter (from 0) of a material as it was set last, or loaded; beyond the last one `name` is
 * NULL. Values stay where they are until the material is set, or a state restored. */
PALPATE_API int32_t palpate_material_parameter(const palpate_simulation* simulation, int32_t material, int32_t index,
                                               palpate_parameter* parameter);

/* (control) The body at rest again, and the tool at its start; friction, materials, loads and pins stay as they were
 * set. Stopped: at once, and what follows has the bits of a new simulation. Running: in the next tick, and the tool
 * then comes back gently. */
PALPATE_API int32_t palpate_reset(palpate_simulation* simulation);

/* (control) Gravity of the tissue, m/s^2 (3), in place of the scene's, and a force on a vertex of the skin, N (3), from
 * the next tick on; a force lasts until it is set to 0, or with vertex -1 and NULL or 0 all are. At most 64 vertices:
 * else PALPATE_REFUSED. PALPATE_BAD_ARGUMENT: a component of gravity beyond 1000 m/s^2, of a force beyond 1e6 N, or no
 * such vertex. They are part of the state, and stay in a reset. No allocation or lock. */
PALPATE_API int32_t palpate_set_gravity(palpate_simulation* simulation, const double* acceleration);
PALPATE_API int32_t palpate_set_force(palpate_simulation* simulation, int32_t vertex, const double* force);

/* (control) Holds a vertex of the skin at a place, m (3), from the next tick on, and moves it as the place is set anew,
 * no faster than the scene's max_speed; NULL lets it go, and with vertex -1 all. At most 64 vertices: else
 * PALPATE_REFUSED. PALPATE_BAD_ARGUMENT: a coordinate beyond 1e6 m, or no such vertex. Where a region holds the tissue,
 * that has its way. As loads, pins are part of the state, and stay in a reset. No allocation or lock. */
PALPATE_API int32_t palpate_pin(palpate_simulation* simulation, int32_t vertex, const double* place);

/* (control, stopped) What a pin does to the tissue: the force on it at that vertex of the skin in the newest step, N
 * (3); 0 where none was held, before the first tick, and after a reset or restore. It is raw, and noisy in motion.
 * PALPATE_BUSY while the simulation runs on its own thread. No allocation or lock. */
PALPATE_API int32_t palpate_pin_force(const palpate_simulation* simulation, int32_t vertex, double* force);

/* (control) Moves a region, m (3), beside what the scene says of it, from the next tick on and no faster than the
 * scene's max_speed; one that is fixed, too. The first 16 regions only: else PALPATE_REFUSED. As palpate_pin in all
 * else.
 * @param region  as of palpate_name; its components that the scene leaves free stay so */
PALPATE_API int32_t palpate_move_region(palpate_simulation* simulation, int32_t region, const double* shift);

/* (control, stopped) Records all input from here on: tools, pulls, loads, pins, regions, friction and materials, those
 * that are set already included. A recording begins at rest: PALPATE_REFUSED after the first tick, unless palpate_reset
 * follows; and as long as it lasts, so are palpate_restore and, stopped, palpate_reset.
 * palpate_record_stop writes what `palpate SCENE --replay FILE` repeats bit for bit (of a model that options.set
 * changed: with a scene file that says so); NULL: nothing is written. Where the file can't be written (PALPATE_FAILED)
 * an earlier one stays, and it goes on recording: name another one. */
PALPATE_API int32_t palpate_record_start(palpate_simulation* simulation, palpate_error* error);
PALPATE_API int32_t palpate_record_stop(palpate_simulation* simulation, const char* file, palpate_error* error);

/* (control) A spring draws a vertex of the skin to a place, m (3), from the next tick on; stiff enough to lead it, soft
 * enough for the time step, and as if no longer than two radii of the tool. One at a time; -1: none. A reset or restore
 * ends it. PALPATE_BAD_ARGUMENT where there is no such vertex. */
PALPATE_API int32_t palpate_pull(palpate_simulation* simulation, int32_t vertex, const double* place);

/* (control, stopped) Calls `call` after each tick, on the thread that has done it, with its outcome; NULL: nobody.
 * While the simulation runs on its own thread the call has a real-time thread's duties: no allocation, no lock, no wait
 * (a debug build ends the program where it has waited), and is part of the tick's time. In it, functions that change
 * the simulation are PALPATE_REFUSED but those marked (hand); those that look at it may be used, those marked (control,
 * stopped) too. What a call throws in C++ ends palpate_step with PALPATE_FAILED, and the program where the simulation
 * runs on its own thread. */
typedef void (*palpate_tick_call)(void* user, const palpate_state* state);
PALPATE_API int32_t palpate_on_tick(palpate_simulation* simulation, palpate_tick_call call, void* user);

/* (control, stopped) The whole state as bytes. A simulation of the same model that restores them goes on bit for bit,
 * friction and materials included. (What the loop keeps to go back to when a solution is lost, and expected_error,
 * begin anew.) Poses and openings that palpate_set_target, palpate_set_tool_target and palpate_set_opening were given
 * since the last tick are not in them, unless palpate_step with n = 0 takes them first; nor are a pull, a recording and
 * a coupling. The bytes are for the same build of the library on the same kind of processor; others refuse them.
 * @param size  palpate_save_size, the same for all simulations of a model */
PALPATE_API size_t palpate_save_size(const palpate_simulation* simulation);
PALPATE_API int32_t palpate_save(const palpate_simulation* simulation, void* bytes, size_t size);
PALPATE_API int32_t palpate_restore(palpate_simulation* simulation, const void* bytes, size_t size,
                                    palpate_error* error);

/* (control, stopped) A hash of the state: equal where all that follows is equal. */
PALPATE_API int32_t palpate_hash(const palpate_simulation* simulation, uint64_t* hash);

/* ---- Equilibria and what they depend on ---- */

/* A body at rest in double, for gradients: its answers and their derivatives to materials. One thread at a time. */

/* What is asked of an equilibrium: the component along `direction`, of any length but 0, of the force on the tool, N;
 * of the force that holds the tissue at a region, N; or of a point's displacement, m. */
enum { PALPATE_TOOL_FORCE = 0, PALPATE_REGION_FORCE = 1, PALPATE_DISPLACEMENT = 2 };
typedef struct palpate_quantity {
  uint32_t size;                /* sizeof(palpate_quantity) */
  int32_t kind;                 /* PALPATE_TOOL_FORCE, ... */
  int32_t index;                /* of the region, or of the point in `points` */
  int32_t unused;               /* 0 */
  const palpate_points* points; /* of a displacement; else NULL */
  double direction[3];
} palpate_quantity;

/* A number of a material, by the name that scenes give it: "young" of the lump. */
typedef struct palpate_material_number {
  int32_t material; /* 0 to material_count - 1: a region's, or a membership class's */
  int32_t entry;    /* of a parameter that is a list; else 0 */
  const char* name;
} palpate_material_number;

/* The body at rest with its tool at a pose, come to along the tool's axis from outside. Takes seconds. It is solved to
 * rounding, with the laws of `mtled solve`: materials that relax after a long time, gravity and prescribed motions of
 * the scene only. PALPATE_BAD_INPUT where the scene has several tools, jaws, friction, rigid bodies, loads on its skin
 * or boundary_method "ebciem", which sensitivities are not for; PALPATE_REFUSED where the body does not come to rest,
 * or the organ, or what holds it, stands in the tool's way.
 * The tool touches the skin's vertices alone: where the skin is stretched by more than half, a simulation's touches
 * more points, and its force may be some percent larger, which palpate_equilibrium_expected_error counts.
 * @param pose     (7); NULL: there is no tool
 * @param time     s, of the scene's prescribed motions; 0: before them
 * @param threads  0: one for each core. No result depends on it */
PALPATE_API int32_t palpate_settle(const palpate_model* model, const double* pose, double time, int32_t threads,
                                   palpate_equilibrium** equilibrium, palpate_error* error);
PALPATE_API void palpate_equilibrium_destroy(palpate_equilibrium* equilibrium);

/* The same body and tool with another value of a number; how node patches average pressure stays as loaded. Where it is
 * refused, all is as before.
 * @param value  receives a quantity */
PALPATE_API int32_t palpate_settle_with(palpate_equilibrium* equilibrium, const palpate_material_number* number,
                                        double value, palpate_error* error);
PALPATE_API int32_t palpate_equilibrium_value(palpate_equilibrium* equilibrium, const palpate_quantity* quantity,
                                              double* value, palpate_error* error);

/* How far off the tool's force is for the nodes that there are, as a share of it; as palpate_state.expected_error, but
 * of all that strains the tissue: where weight or prescribed motions do, too, up to several times what it is there. */
PALPATE_API int32_t palpate_equilibrium_expected_error(palpate_equilibrium* equilibrium, double* share);

/* The derivatives of a quantity to numbers of materials, in its unit over theirs, by the adjoint: one linear solution
 * for a quantity, whatever `count` is; `count` where tissue is pressed to its limit of pressure. They are those of
 * palpate_settle_with: of the answer at rest, the tool standing where it is, with the contact points that there are.
 * Central differences agree to 1e-6.
 * @param derivatives  (count) */
PALPATE_API int32_t palpate_sensitivity(palpate_equilibrium* equilibrium, const palpate_quantity* quantity,
                                        const palpate_material_number* numbers, int32_t count, double* derivatives,
                                        palpate_error* error);

#ifdef __cplusplus
}
#endif

#endif
