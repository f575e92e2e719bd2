/* Plans a scene with the running planner: plan SCENE.json [DOMAIN]. Prints the reply as JSON if
 * CLEARWAY_JSON is set, else a line for each sample: seconds, metres, radians. */
#include <clearway.h>

#include <stdio.h>
#include <stdlib.h>

static int fail(const char *what, clearway_error *error) {
    clearway_refusal refusal;
    fprintf(stderr, "%s: %s\n", what, clearway_error_message(error));
    if (clearway_error_refusal(error, &refusal) && refusal.field != NULL)
        fprintf(stderr, "field: %s\n", refusal.field);
    clearway_error_free(error);
    return EXIT_FAILURE;
}

static char *read_file(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    long size;
    if (file == NULL) return NULL;
    if (fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) >= 0 && fseek(file, 0, SEEK_SET) == 0
        && (text = malloc((size_t)size + 1)) != NULL)
        *length = fread(text, 1, (size_t)size, file);
    fclose(file);
    return text;
}

static int print(const clearway_reply *reply) {
    clearway_error *error = NULL;
    for (size_t answer = 0; answer < clearway_reply_answers(reply); answer++) {
        const clearway_trajectory *trajectory = NULL;
        if (clearway_reply_trajectory(reply, answer, &trajectory, &error) != CLEARWAY_STATUS_OK)
            return fail("answer", error);
        clearway_summary summary = clearway_trajectory_summary(trajectory);
        fprintf(stderr, "%.3f m in %.3f s, %.3f m from the walls\n", summary.length,
                summary.duration, summary.clearance);
        for (size_t block = 0; block < clearway_trajectory_blocks(trajectory); block++) {
            clearway_samples samples = clearway_trajectory_block(trajectory, block);
            for (size_t index = 0; index < samples.count; index++) {
                const clearway_sample *sample = &samples.data[index];
                printf("%.3f %.4f %.4f %.4f %.4f\n", sample->t, sample->position[0],
                       sample->position[1], sample->position[2], sample->heading);
            }
        }
    }
    return EXIT_SUCCESS;
}

int main(int count, char **arguments) {
    clearway_client *client = NULL;
    clearway_scene *scene = NULL;
    clearway_reply *reply = NULL;
    clearway_error *error = NULL;
    size_t length = 0;
    int ended = EXIT_SUCCESS;
    if (count < 2) {
        fprintf(stderr, "usage: plan SCENE.json [DOMAIN]\n");
        return 2;
    }
    char *text = read_file(arguments[1], &length);
    if (text == NULL) {
        perror(arguments[1]);
        return EXIT_FAILURE;
    }
    if (clearway_scene_read(text, length, &scene, &error) != CLEARWAY_STATUS_OK)
        ended = fail(arguments[1], error);
    else if (clearway_connect(count > 2 ? arguments[2] : NULL, 0.0, &client, &error)
             != CLEARWAY_STATUS_OK)
        ended = fail("planner", error);
    else if (clearway_plan(client, scene, 10.0, &reply, &error) != CLEARWAY_STATUS_OK)
        ended = fail(arguments[1], error);
    else if (getenv("CLEARWAY_JSON") != NULL) {
        char *json = clearway_reply_json(reply);
        puts(json);
        clearway_text_free(json);
    } else
        ended = print(reply);
    clearway_reply_free(reply);
    clearway_client_free(client);
    clearway_scene_free(scene);
    free(text);
    return ended;
}
