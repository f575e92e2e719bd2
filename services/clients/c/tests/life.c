/* Threads, forks and planners that die, as seen from C: life PART DOMAIN SCENE.json ENDLESS.json. Parts
 * that wait for something to happen say "asked" or "lost", and go on at a line on stdin; see
 * ../check.sh. Ends with 0 if all was as it must be. */
#include <clearway.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *domain;
static clearway_client *client;
static clearway_scene *scene, *endless;

static void check(bool holds, const char *what) {
    if (holds) return;
    fprintf(stderr, "life: not so: %s\n", what);
    exit(EXIT_FAILURE);
}

static clearway_scene *read_scene(const char *path) {
    static char text[4 << 20];
    clearway_scene *read = NULL;
    FILE *file = fopen(path, "rb");
    check(file != NULL, path);
    size_t length = fread(text, 1, sizeof text, file);
    fclose(file);
    check(clearway_scene_read(text, length, &read, NULL) == CLEARWAY_STATUS_OK, "a scene is read");
    return read;
}

/* The samples of the reply, and what kept it from coming. */
static clearway_status plan(clearway_client *with, size_t *samples, const char *said) {
    clearway_reply *reply = NULL;
    clearway_error *error = NULL;
    clearway_status status = clearway_plan(with, scene, 60.0, &reply, &error);
    *samples = 0;
    if (status != CLEARWAY_STATUS_OK) {
        const char *message = clearway_error_message(error);
        if (strstr(message, said) == NULL) fprintf(stderr, "life: %s\n", message);
        check(strstr(message, said) != NULL, said);
        clearway_error_free(error);
        return status;
    }
    const clearway_trajectory *trajectory = NULL;
    status = clearway_reply_trajectory(reply, 0, &trajectory, NULL);
    for (size_t block = 0; status == CLEARWAY_STATUS_OK && block < clearway_trajectory_blocks(trajectory); block++)
        *samples += clearway_trajectory_block(trajectory, block).count;
    clearway_reply_free(reply);
    return status;
}

static void *ask_often(void *expected) {
    for (int call = 0; call < 200; call++) {
        size_t samples;
        check(plan(client, &samples, "") == CLEARWAY_STATUS_OK, "a thread is answered");
        check(samples == *(size_t *)expected, "each thread has its own reply");
    }
    return NULL;
}

static void threads(void) {
    pthread_t others[2];
    size_t samples;
    check(plan(client, &samples, "") == CLEARWAY_STATUS_OK && samples > 0, "it plans");
    for (int index = 0; index < 2; index++)
        check(pthread_create(&others[index], NULL, ask_often, &samples) == 0, "a thread starts");
    for (int index = 0; index < 2; index++) pthread_join(others[index], NULL);
}

static void forks(void) {
    size_t samples, again;
    check(plan(client, &samples, "") == CLEARWAY_STATUS_OK, "it plans");
    pid_t child = fork();
    if (child == 0) {
        clearway_client *own = NULL;
        check(plan(client, &again, "forked") == CLEARWAY_STATUS_FORKED, "a copy is refused by name");
        check(clearway_connect(domain, 0.0, &own, NULL) == CLEARWAY_STATUS_OK, "it connects anew");
        check(plan(own, &again, "") == CLEARWAY_STATUS_OK && again == samples, "its own is served");
        clearway_client_free(own);
        clearway_client_free(client);
        _exit(0);
    }
    int status = -1;
    waitpid(child, &status, 0);
    check(WIFEXITED(status) && WEXITSTATUS(status) == 0, "the child ends well");
    check(plan(client, &again, "") == CLEARWAY_STATUS_OK && again == samples, "the parent is served");
}

static void say(const char *what) {
    puts(what);
    fflush(stdout);
}

/* Waits for the reply to what takes minutes. */
static clearway_status wait_long(clearway_error **error) {
    clearway_pending *pending = NULL;
    clearway_reply *reply = NULL;
    check(clearway_start(client, endless, &pending, error) == CLEARWAY_STATUS_OK, "it is sent");
    say("asked");
    clearway_status status = clearway_pending_wait(pending, 60.0, &reply, error);
    clearway_pending_free(pending);
    return status;
}

static void killed(void) {
    size_t samples, again;
    clearway_error *error = NULL;
    check(plan(client, &samples, "") == CLEARWAY_STATUS_OK, "it plans");
    check(wait_long(&error) == CLEARWAY_STATUS_PLANNER_LOST, "a killed planner is told");
    check(strstr(clearway_error_message(error), "planner_lost") != NULL, "by name");
    clearway_error_free(error);
    check(plan(client, &again, "no planner runs") == CLEARWAY_STATUS_NO_PLANNER, "there is none");
    say("lost");
    getchar();
    check(plan(client, &again, "") == CLEARWAY_STATUS_OK && again == samples, "the next call works");
}

int main(int count, char **arguments) {
    check(count == 5, "four arguments");
    const char *part = arguments[1];
    domain = arguments[2];
    scene = read_scene(arguments[3]);
    endless = read_scene(arguments[4]);
    check(clearway_connect(domain, 10.0, &client, NULL) == CLEARWAY_STATUS_OK, "it connects");
    if (strcmp(part, "threads") == 0) threads();
    else if (strcmp(part, "forks") == 0) forks();
    else if (strcmp(part, "killed") == 0) killed();
    else if (strcmp(part, "hangs") == 0) wait_long(NULL);
    else check(false, "a part that there is");
    clearway_client_free(client);
    clearway_scene_free(scene);
    clearway_scene_free(endless);
    return 0;
}
