//! Clients, scenes and open requests for C.

use std::ffi::{CStr, c_char, c_int};
use std::time::Duration;

use clearway_client::{ClientOptions, Domain, Wait};

use crate::error::{Error, call, free, given, hand_over};
use crate::reply::Reply;
use crate::values::Status;

/// Asks the planner of a domain.
#[derive(Debug)]
pub struct Client(clearway_client::Client);

/// A scene, prepared to be planned any number of times.
#[derive(Debug)]
pub struct Scene(clearway_client::Scene);

/// A request being answered. Freeing it cancels the request.
#[derive(Debug)]
pub struct Pending(clearway_client::Pending);

/// For waits without a limit, seconds.
const EVER: f64 = 1e9;

fn seconds(what: &str, time: f64) -> Result<Duration, Error> {
    // A NaN is not less than anything.
    Duration::try_from_secs_f64(if time > EVER { EVER } else { time })
        .map_err(|_| Error::invalid(&format!("{what} is {time} s, must be at least 0")))
}

/// Connects to the planner of a domain (NULL: the default domain), waiting up to `patience` seconds
/// for one that is not there yet. Signals are left to the program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_connect(
    domain: *const c_char,
    patience: f64,
    client: *mut *mut Client,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let domain = match domain.is_null() {
                true => Domain::default(),
                false => {
                    let name = CStr::from_ptr(domain).to_str();
                    let name = name.map_err(|_| Error::invalid("domain is not UTF-8"))?;
                    Domain::new(name).map_err(|error| Error::invalid(&error.to_string()))?
                }
            };
            let patience = seconds("patience", patience)?;
            let options = ClientOptions { wait: Wait::Hybrid, patience };
            hand_over(Client(clearway_client::Client::connect_with(&domain, options)?), client)
        })
    }
}

/// Frees a client. It leaves the domain once its replies and pending requests are freed, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_client_free(client: *mut Client) {
    // SAFETY: as the header says.
    unsafe { free(client) };
}

/// Reads a scene from JSON of `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_scene_read(
    json: *const c_char,
    length: usize,
    scene: *mut *mut Scene,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let text = std::slice::from_raw_parts(given(json.cast::<u8>(), "json")?, length);
            let text = std::str::from_utf8(text);
            let text = text.map_err(|_| Error::invalid("the scene is not UTF-8"))?;
            hand_over(Scene(clearway_client::Scene::from_json(text)?), scene)
        })
    }
}

/// The same scene with the name of its free space: it is then sent only to planners that do not know
/// it, which is worth while for maps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_scene_with_name(
    scene: *const Scene,
    named: *mut *mut Scene,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe { call(error, || hand_over(Scene(given(scene, "scene")?.0.with_name()?), named)) }
}

/// Frees a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_scene_free(scene: *mut Scene) {
    // SAFETY: as the header says.
    unsafe { free(scene) };
}

/// Plans a scene, and waits for the reply for at most `timeout` seconds; after that the request is
/// cancelled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_plan(
    client: *const Client,
    scene: *const Scene,
    timeout: f64,
    reply: *mut *mut Reply,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let (client, scene) = (given(client, "client")?, given(scene, "scene")?);
            let limit = seconds("timeout", timeout)?;
            hand_over(Reply::new(client.0.plan(&scene.0, limit)?), reply)
        })
    }
}

/// Sends a scene without waiting.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_start(
    client: *const Client,
    scene: *const Scene,
    pending: *mut *mut Pending,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let (client, scene) = (given(client, "client")?, given(scene, "scene")?);
            hand_over(Pending(client.0.start(&scene.0)?), pending)
        })
    }
}

/// Takes the reply if it is there; else `*reply` is NULL. Once it was taken, or failed with anything
/// but CLEARWAY_STATUS_TIMED_OUT, only clearway_pending_free may follow.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_pending_poll(
    pending: *mut Pending,
    reply: *mut *mut Reply,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let pending = open(pending)?;
            // What comes after this makes the file descriptor readable.
            pending.silence();
            match pending.poll()? {
                Some(found) => hand_over(Reply::new(found), reply),
                None if reply.is_null() => Err(Error::invalid("reply is NULL")),
                None => {
                    reply.write(std::ptr::null_mut());
                    Ok(())
                }
            }
        })
    }
}

/// Waits for the reply, at most `timeout` seconds; after CLEARWAY_STATUS_TIMED_OUT the request is
/// still open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_pending_wait(
    pending: *mut Pending,
    timeout: f64,
    reply: *mut *mut Reply,
    error: *mut *mut Error,
) -> Status {
    // SAFETY: as the header says.
    unsafe {
        call(error, || {
            let limit = seconds("timeout", timeout)?;
            hand_over(Reply::new(open(pending)?.wait(limit)?), reply)
        })
    }
}

/// A file descriptor for event loops: when it can be read, poll. It is open until the request is
/// done; -1 if that is so. Poll every 0.1 s anyway, as planners can die.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_pending_fd(pending: *const Pending) -> c_int {
    // SAFETY: as the header says.
    unsafe { pending.as_ref() }.and_then(|pending| pending.0.bell()).unwrap_or(-1)
}

/// Frees an open request, which cancels it if it is not done.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_pending_free(pending: *mut Pending) {
    // SAFETY: as the header says.
    unsafe { free(pending) };
}

unsafe fn open<'a>(pending: *mut Pending) -> Result<&'a mut clearway_client::Pending, Error> {
    // SAFETY: as the header says.
    let pending = unsafe { pending.as_mut() };
    let pending = pending.ok_or_else(|| Error::invalid("pending is NULL"))?;
    match pending.0.is_open() {
        true => Ok(&mut pending.0),
        false => Err(Error::invalid("the request is done")),
    }
}
