//! Errors for C.

use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use clearway_client::{CallError, ConnectError, Error as ClientError, Refused, message};

use crate::values::{Refusal, Status};

/// Why a call failed.
#[derive(Debug)]
pub struct Error {
    pub(crate) status: Status,
    message: CString,
    refusal: Option<Texts>,
}

/// A refusal with texts for C.
#[derive(Debug)]
struct Texts {
    refused: Refused,
    code: CString,
    message: CString,
    field: Option<CString>,
    setting: Option<CString>,
}

fn text(text: &str) -> CString {
    // No text of a planner has zeros inside but what a scene brought there.
    CString::new(text.replace('\0', "\u{fffd}")).expect("there is none")
}

impl Error {
    pub(crate) fn invalid(message: &str) -> Self {
        Self { status: Status::InvalidArgument, message: text(message), refusal: None }
    }
}

impl From<Refused> for Error {
    fn from(refused: Refused) -> Self {
        let message = text(&refused.to_string());
        let code = text(&refused.code().to_string());
        let message::Refusal { message: said, field, setting, .. } = refused.refusal();
        let said = text(said);
        let [field, setting] = [field, setting].map(|said| said.as_deref().map(text));
        let refusal = Some(Texts { refused, code, message: said, field, setting });
        Self { status: Status::Refused, message, refusal }
    }
}

impl From<ClientError> for Error {
    fn from(error: ClientError) -> Self {
        let status = match error {
            ClientError::Refused(refused) => return refused.into(),
            ClientError::Connect(ConnectError::NoPlanner { .. }) => Status::NoPlanner,
            ClientError::Connect(_) => Status::NotConnected,
            ClientError::Call(CallError::TimedOut { .. }) => Status::TimedOut,
            ClientError::Call(CallError::PlannerLost) => Status::PlannerLost,
            ClientError::Call(CallError::Forked) => Status::Forked,
            ClientError::Call(_) => Status::Failed,
        };
        Self { status, message: text(&error.to_string()), refusal: None }
    }
}

/// Runs a call, and hands its error to C. No panic leaves it.
pub(crate) unsafe fn call(
    error: *mut *mut Error,
    call: impl FnOnce() -> Result<(), Error>,
) -> Status {
    let done = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|_| {
        let message = text("internal: this is a bug");
        Err(Error { status: Status::Failed, message, refusal: None })
    });
    let (status, found) = match done {
        Ok(()) => (Status::Ok, ptr::null_mut()),
        Err(found) => (found.status, Box::into_raw(Box::new(found))),
    };
    match ptr::NonNull::new(error) {
        // SAFETY: it points to where the caller wants the error.
        Some(error) => unsafe { error.write(found) },
        None if !found.is_null() => {
            // SAFETY: it was just made.
            drop(unsafe { Box::from_raw(found) });
        }
        None => {}
    }
    status
}

/// A handle that C gave.
pub(crate) unsafe fn given<'a, T>(handle: *const T, what: &str) -> Result<&'a T, Error> {
    // SAFETY: it is NULL or a handle that is alive.
    unsafe { handle.as_ref() }.ok_or_else(|| Error::invalid(&format!("{what} is NULL")))
}

/// Hands a handle to C.
pub(crate) unsafe fn hand_over<T>(made: T, to: *mut *mut T) -> Result<(), Error> {
    if to.is_null() {
        return Err(Error::invalid("there is no place for the result: it is NULL"));
    }
    // SAFETY: it points to where the caller wants the handle.
    unsafe { to.write(Box::into_raw(Box::new(made))) };
    Ok(())
}

/// Frees a handle that C gives back.
pub(crate) unsafe fn free<T>(handle: *mut T) {
    if !handle.is_null() {
        // SAFETY: it was handed over by `hand_over`, and nobody uses it any more.
        drop(unsafe { Box::from_raw(handle) });
    }
}

/// What an error says, for people.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_error_message(error: *const Error) -> *const c_char {
    // SAFETY: as the header says.
    unsafe { error.as_ref() }.map_or(c"no error".as_ptr(), |error| error.message.as_ptr())
}

/// The refusal of an error with the status CLEARWAY_STATUS_REFUSED; false for others.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_error_refusal(
    error: *const Error,
    refusal: *mut Refusal,
) -> bool {
    // SAFETY: as the header says.
    let said = unsafe { error.as_ref() }.and_then(|error| error.refusal.as_ref());
    let (Some(said), false) = (said, refusal.is_null()) else { return false };
    let pointer = |text: &Option<CString>| text.as_ref().map_or(ptr::null(), |text| text.as_ptr());
    // The texts are those of `said`.
    let &message::Refusal {
        code: _,
        message: _,
        field: _,
        setting: _,
        junction,
        axis,
        needs,
        has,
        least,
        most,
        heading,
    } = said.refused.refusal();
    let filled = Refusal {
        code: said.code.as_ptr(),
        message: said.message.as_ptr(),
        field: pointer(&said.field),
        setting: pointer(&said.setting),
        junction: junction.map_or(-1, |junction| junction as i64),
        axis: axis.map_or(-1, |axis| axis as i32),
        needs: needs.unwrap_or(f64::NAN),
        has: has.unwrap_or(f64::NAN),
        least: least.unwrap_or(f64::NAN),
        most: most.unwrap_or(f64::NAN),
        heading: heading.unwrap_or(f64::NAN),
    };
    // SAFETY: it is not NULL and points to where the caller wants it.
    unsafe { refusal.write(filled) };
    true
}

/// Frees an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clearway_error_free(error: *mut Error) {
    // SAFETY: as the header says.
    unsafe { free(error) };
}
