//! How a camera is moved.

use std::f32::consts::PI;

use glam::{Quat, Vec2, Vec3};
use trisect_scene::{Camera, Lens};

/// A change of the camera's distance by one notch of a wheel.
const NOTCH: f32 = 0.9;

/// A camera moves around a point in front of it, at this distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orbit {
    pub(crate) distance: f32,
}

impl Orbit {
    fn pivot(self, camera: &Camera) -> Vec3 {
        camera.eye + camera.forward * self.distance
    }

    /// Turns the camera about the point, by shares of the picture's height that were dragged to the right
    /// and down: what is in front follows. It does not turn over.
    pub(crate) fn turn(self, camera: &mut Camera, dragged: Vec2) {
        let pivot = self.pivot(camera);
        turn(camera, Quat::from_rotation_y(-dragged.x * PI));
        let mut tilted = camera.clone();
        turn(&mut tilted, Quat::from_axis_angle(camera.right, -dragged.y * PI));
        if tilted.up.y > 0.0 || camera.up.y <= 0.0 {
            *camera = tilted;
        }
        camera.eye = pivot - camera.forward * self.distance;
    }

    /// Moves the camera across, so that what is at the point follows.
    pub(crate) fn pan(self, camera: &mut Camera, dragged: Vec2) {
        let by = dragged * self.seen_height(camera);
        camera.eye += camera.up * by.y - camera.right * by.x;
    }

    /// Goes nearer to the point by notches of a wheel, or farther.
    pub(crate) fn dolly(&mut self, camera: &mut Camera, notches: f32) {
        let share = NOTCH.powf(notches);
        let pivot = self.pivot(camera);
        match &mut camera.lens {
            // It sees the same at every distance.
            Lens::Orthographic { height } => *height *= share,
            Lens::Pinhole { .. } | Lens::Thin { .. } => {
                self.distance *= share;
                camera.eye = pivot - camera.forward * self.distance;
            }
        }
    }

    /// Walks to the right, up and forward, by shares of the point's distance; the point goes along.
    pub(crate) fn walk(&mut self, camera: &mut Camera, by: Vec3) {
        let ahead = match camera.lens {
            Lens::Orthographic { .. } => {
                self.dolly(camera, by.z / (1.0 - NOTCH));
                0.0
            }
            Lens::Pinhole { .. } | Lens::Thin { .. } => by.z,
        };
        let across = camera.right * by.x + camera.up * by.y;
        camera.eye += (across + camera.forward * ahead) * self.distance;
    }

    /// Height of what the picture shows at the point's distance.
    fn seen_height(self, camera: &Camera) -> f32 {
        let height = camera.lens.half_height() * 2.0;
        match camera.lens {
            Lens::Orthographic { .. } => height,
            Lens::Pinhole { .. } | Lens::Thin { .. } => height * self.distance,
        }
    }
}

/// Turns a camera where it stands.
fn turn(camera: &mut Camera, by: Quat) {
    camera.forward = (by * camera.forward).normalize();
    // At right angles still after thousands of turns.
    camera.right = camera.forward.cross(by * camera.up).normalize();
    camera.up = camera.right.cross(camera.forward);
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Vec3 = Vec3::new(1.0, 2.0, -3.0);

    fn start(lens: Lens) -> (Camera, Orbit) {
        let eye = AT + Vec3::new(0.0, 0.0, 5.0);
        (Camera::looking(eye, AT, Vec3::Y, lens).expect("a direction"), Orbit { distance: 5.0 })
    }

    fn pinhole() -> (Camera, Orbit) {
        start(Lens::Pinhole { field_of_view: 1.0 })
    }

    fn is_sound(camera: &Camera) {
        let axes = [camera.right, camera.up, -camera.forward];
        for (i, a) in axes.iter().enumerate() {
            for (j, b) in axes.iter().enumerate() {
                assert!((a.dot(*b) - f32::from(u8::from(i == j))).abs() < 1e-5, "{camera:?}");
            }
        }
        assert!(axes[0].cross(axes[1]).dot(axes[2]) > 0.9);
    }

    #[test]
    fn turning_keeps_the_point_in_the_middle_and_the_camera_upright() {
        let (mut camera, orbit) = pinhole();
        for _ in 0..1000 {
            orbit.turn(&mut camera, Vec2::new(0.013, 0.021));
            is_sound(&camera);
            assert!((camera.eye + camera.forward * 5.0 - AT).length() < 1e-3);
            assert!(camera.up.y > 0.0);
        }
        // Dragged down it has gone up.
        assert!(camera.eye.y > AT.y + 4.5);
    }

    #[test]
    fn dragging_to_the_right_turns_the_scene_to_the_right() {
        let (mut camera, orbit) = pinhole();
        orbit.turn(&mut camera, Vec2::new(0.5, 0.0));
        assert!((camera.eye - (AT - Vec3::new(5.0, 0.0, 0.0))).length() < 1e-5, "{}", camera.eye);
    }

    #[test]
    fn panning_moves_the_point_with_the_hand() {
        for lens in [Lens::Pinhole { field_of_view: 1.0 }, Lens::Orthographic { height: 3.0 }] {
            let (mut camera, orbit) = start(lens);
            orbit.pan(&mut camera, Vec2::new(0.25, -0.125));
            // Where the point is in the picture now, in heights from its middle.
            let seen = orbit.seen_height(&camera);
            let from = AT - camera.eye;
            let at = Vec2::new(from.dot(camera.right), from.dot(camera.up)) / seen;
            assert!((at - Vec2::new(0.25, 0.125)).length() < 1e-6, "{at}");
        }
    }

    #[test]
    fn a_wheel_brings_the_point_nearer_and_never_beyond() {
        let (mut camera, mut orbit) = pinhole();
        for _ in 0..100 {
            orbit.dolly(&mut camera, 1.0);
        }
        assert!(orbit.distance > 0.0 && orbit.distance < 1e-3);
        assert!((camera.eye - AT).length() < 1e-3);
        let (mut camera, mut orbit) = start(Lens::Orthographic { height: 3.0 });
        let eye = camera.eye;
        orbit.dolly(&mut camera, -1.0);
        assert_eq!((camera.eye, camera.lens), (eye, Lens::Orthographic { height: 3.0 / NOTCH }));
    }

    #[test]
    fn walking_goes_where_the_camera_looks() {
        let (mut camera, mut orbit) = pinhole();
        orbit.walk(&mut camera, Vec3::new(0.1, 0.2, 0.4));
        assert!((camera.eye - (AT + Vec3::new(0.5, 1.0, 3.0))).length() < 1e-6);
        assert_eq!(orbit.distance, 5.0);
    }
}
