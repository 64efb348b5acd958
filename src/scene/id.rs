//! Ids as types, so that an image is never looked up by a camera's number.

use std::fmt;

macro_rules! ids {
    ($($(#[$doc:meta])* $Id:ident($number:ty)),+ $(,)?) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $Id(pub $number);

        impl fmt::Display for $Id {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )+};
}

ids! {
    /// A camera's number within one reconstruction; other reconstructions may number otherwise.
    CameraId(u32),
    /// An image's number within one reconstruction.
    ImageId(u32),
    /// A rig's number within one reconstruction.
    RigId(u32),
    /// A frame's number within one reconstruction.
    FrameId(u32),
    /// A point's number within one reconstruction. COLMAP's 2^64 - 1 (-1 in text) stands for none and is no id.
    Point3DId(u64),
}
