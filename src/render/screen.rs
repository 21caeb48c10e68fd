//! A canvas as something to draw on: WebGPU's adapter, device and surface, and what goes wrong with them.
//! The first fault of a device is every screen's that draws with it.

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wasm_bindgen::{JsCast, JsValue};
use wgpu::*;

/// Why nothing can be drawn, or no longer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScreenError {
    /// The browser has no WebGPU, or no adapter for it.
    #[error("WebGPU is not available: {0}")]
    Unsupported(String),
    /// The value given is no canvas, or it is in other use.
    #[error("canvas: expected an OffscreenCanvas or a canvas element that nothing draws on yet, found {0}")]
    Canvas(String),
    /// The device is gone: the driver restarted, or the browser took it away.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The GPU refused a command or ran out of memory.
    #[error("the graphics device reported an error: {0}")]
    Device(String),
}

impl ScreenError {
    /// A short word for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Unsupported(_) => "unsupported",
            Self::Canvas(_) => "canvas",
            Self::Lost(_) => "device-lost",
            Self::Device(_) => "device",
        }
    }
}

/// The first thing that went wrong, told by WebGPU's callbacks.
type Fault = Arc<Mutex<Option<ScreenError>>>;

/// A device, and where it came from. All canvases of a thread draw with the same one: it goes when the last of them does.
struct Gpu {
    instance: Instance,
    adapter: Adapter,
    device: Device,
    queue: Queue,
    fault: Fault,
}

thread_local! {
    static SHARED: RefCell<Weak<Gpu>> = const { RefCell::new(Weak::new()) };
    static DEVICES: Cell<usize> = const { Cell::new(0) };
}

impl Gpu {
    /// The thread's device; another one where there is none yet, or where it has a fault. Must not be called while an earlier call waits.
    async fn shared(features: Features) -> Result<Rc<Self>, ScreenError> {
        let found = SHARED.with_borrow(Weak::upgrade).filter(|gpu| lock(&gpu.fault).is_none());
        if let Some(gpu) = found {
            return Ok(gpu);
        }
        let gpu = Rc::new(Self::new(features).await?);
        SHARED.set(Rc::downgrade(&gpu));
        Ok(gpu)
    }

    async fn new(features: Features) -> Result<Self, ScreenError> {
        let instance = util::new_instance_with_webgpu_detection(InstanceDescriptor {
            backends: Backends::BROWSER_WEBGPU,
            ..InstanceDescriptor::new_without_display_handle()
        })
        .await;
        let adapter = instance
            .request_adapter(&RequestAdapterOptions {
                power_preference: PowerPreference::HighPerformance,
                ..Default::default()
            })
            .await
            .map_err(|error| ScreenError::Unsupported(error.to_string()))?;
        let (device, queue) = adapter
            .request_device(&DeviceDescriptor {
                required_features: adapter.features() & features,
                ..Default::default()
            })
            .await
            .map_err(|error| ScreenError::Unsupported(error.to_string()))?;
        let fault = watch(&device);
        DEVICES.set(DEVICES.get() + 1);
        Ok(Self { instance, adapter, device, queue, fault })
    }
}

/// Devices of this thread that are in use.
pub fn device_count() -> usize {
    DEVICES.get()
}

impl Drop for Gpu {
    fn drop(&mut self) {
        DEVICES.set(DEVICES.get() - 1);
        self.device.destroy();
    }
}

/// A canvas and the device that draws on it.
pub struct Screen {
    surface: Surface<'static>,
    gpu: Rc<Gpu>,
    configuration: SurfaceConfiguration,
    configured: bool,
    /// Pictures handed to the GPU and not finished.
    unfinished: Arc<AtomicU32>,
    adapter_info: AdapterInfo,
}

/// More unfinished pictures than this only make the picture late.
const MOST_UNFINISHED: u32 = 2;

impl Screen {
    /// Asks for a device that can draw on `canvas`, with those of `features` that the adapter has: the one that the thread's other screens
    /// use, if there are any. Nothing beyond WebGPU's default limits is wanted. One call at a time.
    pub async fn new(canvas: JsValue, features: Features) -> Result<Self, ScreenError> {
        let gpu = Gpu::shared(features).await?;
        let surface =
            gpu.instance.create_surface(target(canvas)?).map_err(|error| ScreenError::Canvas(error.to_string()))?;
        let configuration = configuration(&surface, &gpu.adapter)?;
        let adapter_info = gpu.adapter.get_info();
        Ok(Self { surface, gpu, configuration, configured: false, unfinished: Arc::default(), adapter_info })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.gpu.device
    }

    /// What is known of the adapter.
    pub fn adapter_info(&self) -> &AdapterInfo {
        &self.adapter_info
    }

    /// Its queue.
    pub fn queue(&self) -> &Queue {
        &self.gpu.queue
    }

    /// Format of the views that [`Self::present`] hands out: no `…Srgb` one; the browser shows its numbers as sRGB.
    pub fn format(&self) -> TextureFormat {
        self.configuration.format
    }

    /// Sets the picture's size, pixels. Nothing is drawn while either is zero.
    pub fn resize(&mut self, size: [u32; 2]) {
        let limit = self.gpu.device.limits().max_texture_dimension_2d;
        self.configuration.width = size[0].min(limit);
        self.configuration.height = size[1].min(limit);
        self.configured = false;
    }

    /// Whether the GPU keeps up, so that another picture may be drawn.
    pub fn keeps_up(&self) -> bool {
        self.unfinished.load(Ordering::Relaxed) < MOST_UNFINISHED
    }

    /// Lets `draw` fill the next picture, given its view and its size, and shows it. Returns whether there was one to fill.
    pub fn present(&mut self, draw: impl FnOnce(&TextureView, [u32; 2])) -> bool {
        let size = [self.configuration.width, self.configuration.height];
        if size.contains(&0) {
            return false;
        }
        if !self.configured {
            self.surface.configure(&self.gpu.device, &self.configuration);
            self.configured = true;
        }
        let (CurrentSurfaceTexture::Success(picture) | CurrentSurfaceTexture::Suboptimal(picture)) =
            self.surface.get_current_texture()
        else {
            self.configured = false;
            return false;
        };
        draw(&picture.texture.create_view(&TextureViewDescriptor::default()), size);
        self.gpu.queue.present(picture);
        self.unfinished.fetch_add(1, Ordering::Relaxed);
        let unfinished = self.unfinished.clone();
        self.gpu.queue.on_submitted_work_done(move || {
            unfinished.fetch_sub(1, Ordering::Relaxed);
        });
        true
    }

    /// The first error since the start, if there was one.
    pub fn check(&self) -> Result<(), ScreenError> {
        lock(&self.gpu.fault).clone().map_or(Ok(()), Err)
    }

    /// Loses the device as a driver's restart does, for tests.
    pub fn lose(&self) {
        self.gpu.device.destroy();
        lock(&self.gpu.fault).get_or_insert(ScreenError::Lost("destroyed on demand".into()));
    }
}

fn target(canvas: JsValue) -> Result<SurfaceTarget<'static>, ScreenError> {
    let canvas = match canvas.dyn_into::<web_sys::OffscreenCanvas>() {
        Ok(canvas) => return Ok(SurfaceTarget::OffscreenCanvas(canvas)),
        Err(other) => other,
    };
    match canvas.dyn_into::<web_sys::HtmlCanvasElement>() {
        Ok(canvas) => Ok(SurfaceTarget::Canvas(canvas)),
        Err(other) => Err(ScreenError::Canvas(format!("{other:?}"))),
    }
}

fn configuration(surface: &Surface<'_>, adapter: &Adapter) -> Result<SurfaceConfiguration, ScreenError> {
    let mut configuration = surface
        .get_default_config(adapter, 0, 0)
        .ok_or_else(|| ScreenError::Unsupported("the adapter cannot draw on a canvas".into()))?;
    configuration.format = configuration.format.remove_srgb_suffix();
    configuration.alpha_mode = CompositeAlphaMode::PreMultiplied;
    Ok(configuration)
}

fn lock(fault: &Fault) -> MutexGuard<'_, Option<ScreenError>> {
    fault.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps the first error of `device`.
fn watch(device: &Device) -> Fault {
    let fault = Fault::default();
    let of_errors = fault.clone();
    device.on_uncaptured_error(Arc::new(move |error: Error| {
        lock(&of_errors).get_or_insert(ScreenError::Device(error.to_string()));
    }));
    let of_loss = fault.clone();
    device.set_device_lost_callback(move |reason, message| {
        if reason != DeviceLostReason::Destroyed {
            lock(&of_loss).get_or_insert(ScreenError::Lost(message));
        }
    });
    fault
}
