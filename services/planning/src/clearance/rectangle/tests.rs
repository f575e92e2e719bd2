//! Facts about the exact clearance, and a dense recheck that shares no code with it.
