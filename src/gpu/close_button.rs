//! A window's close button as a request, not as the end.
//!
//! egui-ash ends its event loop as soon as winit reports the button, whatever the program wants, and a process has one
//! loop only. So winit does not get to see the window manager's message: it is taken out where Xlib turns the server's
//! bytes into events, by the hook that Xlib has for extensions. Every other message passes through.

use egui_ash::raw_window_handle::{HasRawDisplayHandle, RawDisplayHandle};
use egui_ash::winit::window::Window;
use std::ffi::c_int;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::OnceLock;
use x11_dl::xlib::{self, Xlib};

type Convert = unsafe extern "C" fn(*mut xlib::Display, *mut xlib::XEvent, *mut xlib::xEvent) -> c_int;

// The hook has no argument of its own. A process has one event loop, and that one display.
static PRESSED: AtomicBool = AtomicBool::new(false);
static PROTOCOLS: AtomicUsize = AtomicUsize::new(0);
static DELETE_WINDOW: AtomicUsize = AtomicUsize::new(0);
static BEFORE: OnceLock<Convert> = OnceLock::new();

/// The close button of the window.
pub struct CloseButton(());

impl CloseButton {
    /// Takes the button over; `None` where the window is not one of X11.
    pub fn take(window: &Window) -> Option<CloseButton> {
        let RawDisplayHandle::Xlib(handle) = window.raw_display_handle() else { return None };
        let xlib = Xlib::open().ok()?;
        let display: *mut xlib::Display = handle.display.cast();
        if display.is_null() || BEFORE.get().is_some() {
            return None;
        }
        // SAFETY: winit's display is open as long as its window; names end in nul; the hook is a plain function that
        // never goes, and what it reads is written before it is set.
        unsafe {
            let atom = |name: &std::ffi::CStr| (xlib.XInternAtom)(display, name.as_ptr(), xlib::False);
            PROTOCOLS.store(atom(c"WM_PROTOCOLS") as usize, Ordering::Relaxed);
            DELETE_WINDOW.store(atom(c"WM_DELETE_WINDOW") as usize, Ordering::Relaxed);
            // Who converts until now is known only by putting somebody in his place.
            let before = (xlib.XESetWireToEvent)(display, xlib::ClientMessage, None);
            (xlib.XESetWireToEvent)(display, xlib::ClientMessage, before);
            BEFORE.set(before?).ok()?;
            (xlib.XESetWireToEvent)(display, xlib::ClientMessage, Some(convert));
        }
        Some(CloseButton(()))
    }

    /// Whether it was pressed since the last time somebody asked.
    pub fn pressed(&self) -> bool {
        PRESSED.swap(false, Ordering::Relaxed)
    }
}

/// In place of Xlib's conversion of client messages: 0 leaves the event out. Xlib holds its lock meanwhile, so nothing
/// in here may call it.
unsafe extern "C" fn convert(display: *mut xlib::Display, event: *mut xlib::XEvent, wire: *mut xlib::xEvent) -> c_int {
    let Some(before) = BEFORE.get() else { return 0 };
    // SAFETY: the arguments are Xlib's own, and so is the function that they go to.
    let kept = unsafe { before(display, event, wire) };
    if kept == 0 {
        return 0;
    }
    // SAFETY: the conversion has filled the event in, as a client message.
    let message = unsafe { &(*event).client_message };
    let asks = message.message_type as usize == PROTOCOLS.load(Ordering::Relaxed)
        && message.format == 32
        && message.data.get_long(0) as usize == DELETE_WINDOW.load(Ordering::Relaxed);
    if asks {
        PRESSED.store(true, Ordering::Relaxed);
        return 0;
    }
    kept
}
