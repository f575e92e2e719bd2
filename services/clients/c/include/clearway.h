/* Plans collision-free motions with a Clearway planner over shared memory, and reads them where
 * they lie. Generated from services/clients/c/src; `cargo bless` renews it.
 *
 * Units: metres, radians, seconds. Scenes are JSON (docs/interface.md).
 *
 * Handles: what a function puts into its last but one argument belongs to the caller, who frees it
 * with the `_free` function of its kind, once, in any order; NULL may be freed. What a function
 * returns as a pointer to const belongs to the handle it was asked of.
 *
 * Errors: functions that return a clearway_status put an error into their last argument if that is
 * not NULL and the status is not CLEARWAY_STATUS_OK; the caller frees it.
 *
 * Threads: clients, scenes, replies and all that belongs to them may be used by several threads at
 * a time. A pending request and an error are for one thread at a time. Anything may be freed by any
 * thread, once nobody uses it. After a fork the child may free what it inherited, and needs a client
 * of its own.
 */

#ifndef CLEARWAY_H
#define CLEARWAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// How a call ended.
typedef enum clearway_status {
    // Done.
    CLEARWAY_STATUS_OK = 0,
    // An argument is NULL, not UTF-8 or out of range.
    CLEARWAY_STATUS_INVALID_ARGUMENT = 1,
    // No planner runs in the domain.
    CLEARWAY_STATUS_NO_PLANNER = 2,
    // The planner can't be reached.
    CLEARWAY_STATUS_NOT_CONNECTED = 3,
    // The planner refuses, and says what would have to change: clearway_error_refusal.
    CLEARWAY_STATUS_REFUSED = 4,
    // No reply came in time.
    CLEARWAY_STATUS_TIMED_OUT = 5,
    // The planner ended before it replied.
    CLEARWAY_STATUS_PLANNER_LOST = 6,
    // The client was connected before this process was forked.
    CLEARWAY_STATUS_FORKED = 7,
    // The request was sent, and no reply came, for another reason.
    CLEARWAY_STATUS_FAILED = 8,
} clearway_status;

// Ways out of a part.
typedef enum clearway_exit {
    // None is reported.
    CLEARWAY_EXIT_NONE = 0,
    // Towards greater x.
    CLEARWAY_EXIT_PLUS_X = 1,
    // Towards smaller x.
    CLEARWAY_EXIT_MINUS_X = 2,
    // Towards greater y.
    CLEARWAY_EXIT_PLUS_Y = 3,
    // Towards smaller y.
    CLEARWAY_EXIT_MINUS_Y = 4,
    // Towards greater z.
    CLEARWAY_EXIT_PLUS_Z = 5,
    // Towards smaller z.
    CLEARWAY_EXIT_MINUS_Z = 6,
} clearway_exit;

// Limits that motions may not obey.
typedef enum clearway_limit {
    // None is exceeded, or none is reported.
    CLEARWAY_LIMIT_NONE = 0,
    // The yaw rate jumps where the curvature does.
    CLEARWAY_LIMIT_YAW_ACCELERATION = 1,
} clearway_limit;

// The kinds of legs.
typedef enum clearway_leg_kind {
    // A straight line.
    CLEARWAY_LEG_KIND_LINE = 0,
    // A part of a circle.
    CLEARWAY_LEG_KIND_ARC = 1,
    // A turn in place.
    CLEARWAY_LEG_KIND_TURN = 2,
    // A curve whose curvature changes evenly with its arc length.
    CLEARWAY_LEG_KIND_CLOTHOID = 3,
} clearway_leg_kind;

// How a leg was found.
typedef enum clearway_rung {
    // None is reported.
    CLEARWAY_RUNG_NONE = 0,
    // On the shortest path around the corners, at the gap asked for.
    CLEARWAY_RUNG_TAUT = 1,
    // With another radius at the corners where the robot would not fit.
    CLEARWAY_RUNG_RADIUS = 2,
    // By lining up: straight legs between turns in place.
    CLEARWAY_RUNG_ALIGNED = 3,
    // With legs in reverse.
    CLEARWAY_RUNG_REVERSE = 4,
    // By a search over positions and headings.
    CLEARWAY_RUNG_LATTICE = 5,
} clearway_rung;

// Asks the planner of a domain.
typedef struct clearway_client clearway_client;

// Why a call failed.
typedef struct clearway_error clearway_error;

// A request being answered. Freeing it cancels the request.
typedef struct clearway_pending clearway_pending;

// A reply: an answer for each clearance asked for.
typedef struct clearway_reply clearway_reply;

// A scene, prepared to be planned any number of times.
typedef struct clearway_scene clearway_scene;

// A planned and sampled motion, of a reply.
typedef struct clearway_trajectory clearway_trajectory;

// A refusal. Texts live as long as the error; what does not apply is NULL, NaN or -1.
typedef struct clearway_refusal {
    // Its code, such as "junction_too_small".
    const char *code;
    // For people, with the numbers; its wording may change.
    const char *message;
    // The field of the scene that is at fault, as a path.
    const char *field;
    // The setting of the planner whose limit was met.
    const char *setting;
    // The junction, counted from 0 in travel order.
    int64_t junction;
    // The axis: 0 x, 1 y, 2 z.
    int32_t axis;
    // What would be needed.
    double needs;
    // What there is.
    double has;
    // The bound below, itself excluded.
    double least;
    // The bound above.
    double most;
    // The heading that would be free, radians.
    double heading;
} clearway_refusal;

// A limit that a motion does not obey.
typedef struct clearway_exceeds {
    // The limit.
    enum clearway_limit limit;
    // At how many joints of legs.
    uint64_t joints;
    // The greatest jump there of what the limit bounds the rate of, radians per second.
    double jump;
} clearway_exceeds;

// What a trajectory says beside its lists. Metres and seconds.
typedef struct clearway_summary {
    // Arc length.
    double length;
    // Seconds.
    double duration;
    // Exact least distance of the body to the walls; infinite without walls.
    double clearance;
    // Arc length where that is met.
    double clearance_at;
    // The wall point there.
    double clearance_wall[3];
    // Length of the shortest curve with the same free clearance; NaN if it is not reported.
    double bound;
    // Free clearance; NaN if it is not reported.
    double free_clearance;
    // Coordinates of positions: 2 or 3.
    uint32_t dimension;
    // Whether the search ended by itself and not because its budget was spent.
    bool complete;
    // The way out that was taken, if the request gave several.
    enum clearway_exit exit;
    // With smooth corners: at how many joints of legs the body stops because none fits; -1 if it is
    // not reported.
    int64_t stops;
    // The limit that the motion does not obey.
    struct clearway_exceeds exceeds;
} clearway_summary;

// A state of the motion.
typedef struct clearway_sample {
    // Seconds from the beginning of the motion.
    double t;
    // Metres; unused coordinates are 0. Of parts the displacement from the assembled state, of
    // robots the reference point.
    double position[3];
    // Radians counter-clockwise from +x, in (-pi, pi].
    double heading;
    // Metres per second.
    double velocity[3];
    // Radians per second.
    double yaw_rate;
} clearway_sample;

// Samples that follow each other.
typedef struct clearway_samples {
    // The first; never NULL.
    const struct clearway_sample *data;
    // How many there are.
    size_t count;
} clearway_samples;

// A piece of a path. Metres; radians counter-clockwise from +x. What its kind does not have is 0.
typedef struct clearway_leg {
    // Which kind.
    enum clearway_leg_kind kind;
    // Whether the robot drives it backwards.
    bool reverse;
    // Table of the rule that chose it, 0 for none.
    uint16_t table;
    // Number of the rule in it.
    uint16_t number;
    // How it was found.
    enum clearway_rung rung;
    // The junction it leads to or turns in, counted from 0 in travel order; -1 for none.
    int64_t junction;
    // Arc length.
    double length;
    // Least distance to the walls on it: exact, but on a clothoid certified from below; infinite
    // without walls.
    double clearance;
    // Line, clothoid: from. Arc: centre. Turn: position.
    double point[3];
    // Line, clothoid: to.
    double to[3];
    // Arc: radius.
    double radius;
    // Arc: angle from the centre to the arriving point. Turn, clothoid: heading before.
    double start;
    // Line: heading at its end. Turn, clothoid: heading after.
    double heading;
    // Arc, turn: signed angle, positive to the left. Line: signed angle turned on the way.
    double sweep;
    // Clothoid: radians turned per metre where it begins and where it ends, positive to the left.
    double curvatures[2];
} clearway_leg;

// A box with sides parallel to the axes, metres; unused coordinates are 0.
typedef struct clearway_box {
    // The corner with the least coordinates.
    double min[3];
    // The corner with the greatest coordinates.
    double max[3];
} clearway_box;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// What an error says, for people.
const char *clearway_error_message(const struct clearway_error *error);

// The refusal of an error with the status CLEARWAY_STATUS_REFUSED; false for others.
bool clearway_error_refusal(const struct clearway_error *error, struct clearway_refusal *refusal);

// Frees an error.
void clearway_error_free(struct clearway_error *error);

// How many answers a reply has, one for each clearance asked for; 0 for NULL.
size_t clearway_reply_answers(const struct clearway_reply *reply);

// Whether all samples are where the planner wrote them, in shared memory. A client with many replies
// alive copies the later ones, so that the planner has room to write.
bool clearway_reply_is_shared(const struct clearway_reply *reply);

// The scene's id, if it has one.
bool clearway_reply_id(const struct clearway_reply *reply, uint64_t *id);

// The trajectory of an answer; CLEARWAY_STATUS_REFUSED if the answer is a refusal.
enum clearway_status clearway_reply_trajectory(const struct clearway_reply *reply,
                                               size_t answer,
                                               const struct clearway_trajectory **trajectory,
                                               struct clearway_error **error);

// The reply as `plan --format json` prints it, to be freed with clearway_text_free; NULL for NULL.
char *clearway_reply_json(const struct clearway_reply *reply);

// Frees a text.
void clearway_text_free(char *text);

// Frees a reply, and with it its trajectories and their samples.
void clearway_reply_free(struct clearway_reply *reply);

// What a trajectory says beside its lists. `trajectory` must not be NULL.
struct clearway_summary clearway_trajectory_summary(const struct clearway_trajectory *trajectory);

// How many blocks of samples a trajectory has; 0 for NULL.
size_t clearway_trajectory_blocks(const struct clearway_trajectory *trajectory);

// The samples of a block, where the planner wrote them; they go on in the next block. None if there
// is no such block.
struct clearway_samples clearway_trajectory_block(const struct clearway_trajectory *trajectory,
                                                  size_t block);

// How many legs a trajectory has; 0 for NULL.
size_t clearway_trajectory_legs(const struct clearway_trajectory *trajectory);

// A leg of a trajectory; false if there is no such leg.
bool clearway_trajectory_leg(const struct clearway_trajectory *trajectory,
                             size_t index,
                             struct clearway_leg *leg);

// The channels travelled, as indices into those of the scene, in travel order: `*count` of them.
const uint64_t *clearway_trajectory_route(const struct clearway_trajectory *trajectory,
                                          size_t *count);

// The gaps used, metres, junction by junction in travel order: `*count` of them, `*each` for every
// junction.
const double *clearway_trajectory_gaps(const struct clearway_trajectory *trajectory,
                                       size_t *count,
                                       size_t *each);

// How many channels the planner made for a trajectory, which its route counts; 0 if the scene has
// them, and for NULL.
size_t clearway_trajectory_channels(const struct clearway_trajectory *trajectory);

// A channel that the planner made; false if there is no such channel.
bool clearway_trajectory_channel(const struct clearway_trajectory *trajectory,
                                 size_t index,
                                 struct clearway_box *channel);

// Connects to the planner of a domain (NULL: the default domain), waiting up to `patience` seconds
// for one that is not there yet. Signals are left to the program.
enum clearway_status clearway_connect(const char *domain,
                                      double patience,
                                      struct clearway_client **client,
                                      struct clearway_error **error);

// Frees a client. It leaves the domain once its replies and pending requests are freed, too.
void clearway_client_free(struct clearway_client *client);

// Reads a scene from JSON of `length` bytes.
enum clearway_status clearway_scene_read(const char *json,
                                         size_t length,
                                         struct clearway_scene **scene,
                                         struct clearway_error **error);

// The same scene with the name of its free space: it is then sent only to planners that do not know
// it, which is worth while for maps.
enum clearway_status clearway_scene_with_name(const struct clearway_scene *scene,
                                              struct clearway_scene **named,
                                              struct clearway_error **error);

// Frees a scene.
void clearway_scene_free(struct clearway_scene *scene);

// Plans a scene, and waits for the reply for at most `timeout` seconds; after that the request is
// cancelled.
enum clearway_status clearway_plan(const struct clearway_client *client,
                                   const struct clearway_scene *scene,
                                   double timeout,
                                   struct clearway_reply **reply,
                                   struct clearway_error **error);

// Sends a scene without waiting.
enum clearway_status clearway_start(const struct clearway_client *client,
                                    const struct clearway_scene *scene,
                                    struct clearway_pending **pending,
                                    struct clearway_error **error);

// Takes the reply if it is there; else `*reply` is NULL. Once it was taken, or failed with anything
// but CLEARWAY_STATUS_TIMED_OUT, only clearway_pending_free may follow.
enum clearway_status clearway_pending_poll(struct clearway_pending *pending,
                                           struct clearway_reply **reply,
                                           struct clearway_error **error);

// Waits for the reply, at most `timeout` seconds; after CLEARWAY_STATUS_TIMED_OUT the request is
// still open.
enum clearway_status clearway_pending_wait(struct clearway_pending *pending,
                                           double timeout,
                                           struct clearway_reply **reply,
                                           struct clearway_error **error);

// A file descriptor for event loops: when it can be read, poll. It is open until the request is
// done; -1 if that is so. Poll every 0.1 s anyway, as planners can die.
int clearway_pending_fd(const struct clearway_pending *pending);

// Frees an open request, which cancels it if it is not done.
void clearway_pending_free(struct clearway_pending *pending);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CLEARWAY_H */
