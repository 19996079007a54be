//! A virtual mecanum robot: drives, docks, carries loads, and talks to the signal endpoints of a cell.
