//! State machines of the cell: jobs, hand-over sessions, permits, custody. No I/O, no clock.
