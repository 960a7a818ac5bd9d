"""Every form of pixels is read with the right values, or refused in one line."""

import io
import struct
import zlib

import numpy as np
import pytest
import tifffile
from PIL import Image

from avs.scene.images import is_translucent, open_rgb, read_header, read_image
from avs.system.errors import UserError

# Four colours; the last is transparent where a form has transparency, with noise below.
COLORS = np.array([[[255, 0, 0], [0, 128, 255]], [[60, 70, 80], [200, 10, 90]]], np.uint8)
OPACITY = np.array([[255, 255], [255, 0]], np.uint8)
BACKGROUND = (0.2, 0.4, 0.6)  # 51, 102, 153 of 255
CUT = np.array([[[255, 0, 0], [0, 128, 255]], [[60, 70, 80], [51, 102, 153]]], np.uint8)
GREY = np.array([[0, 255], [128, 77]], np.uint8)
WIDE = COLORS.astype(np.uint16) * 257
GREYS = np.repeat(GREY[..., None], 3, axis=2)
GREY_CUT = np.array([[[0] * 3, [255] * 3], [[128] * 3, [51, 102, 153]]], np.uint8)


def chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png(samples, depth, color_type, *extra):
    """A PNG of any depth and type, ``samples`` as big-endian rows."""
    height, width = samples.shape[:2]
    header = struct.pack(">IIBBBBB", width, height, depth, color_type, 0, 0, 0)
    rows = b"".join(b"\0" + row.astype(">u2" if depth == 16 else "u1").tobytes() for row in samples)
    parts = [chunk(b"IHDR", header), *extra, chunk(b"IDAT", zlib.compress(rows)), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def tiff(samples, **options):
    stream = io.BytesIO()
    tifffile.imwrite(stream, samples, metadata=None, **options)
    return stream.getvalue()


def saved(image, form, **options):
    stream = io.BytesIO()
    image.save(stream, form, **options)
    return stream.getvalue()


def with_opacity(samples, opacity):
    return np.concatenate([samples, opacity[..., None]], axis=2)


def palette(transparency=None):
    extra = [chunk(b"PLTE", COLORS.tobytes())]
    if transparency is not None:
        extra.append(chunk(b"tRNS", bytes(transparency)))
    return png(np.array([[0, 1], [2, 3]], np.uint8), 8, 3, *extra)


RGB = Image.fromarray(COLORS)
RGBA = Image.fromarray(with_opacity(COLORS, OPACITY))
LA = Image.fromarray(with_opacity(GREY[..., None], OPACITY), "LA")
BITS = np.array([[0, 255], [255, 0]], np.uint8)
INKS = 255 - with_opacity(COLORS, np.full((2, 2), 255, np.uint8))  # cyan, magenta and yellow, no black
READ = {
    "png rgb": (saved(RGB, "PNG"), COLORS),
    "png rgba": (saved(RGBA, "PNG"), CUT),
    "png grey": (saved(Image.fromarray(GREY), "PNG"), GREYS),
    "png grey alpha": (saved(LA, "PNG"), GREY_CUT),
    "png palette": (palette(), COLORS),
    "png palette with transparency": (palette([255, 255, 255, 0]), CUT),
    "png transparent colour": (png(COLORS, 8, 2, chunk(b"tRNS", struct.pack(">HHH", 200, 10, 90))), CUT),
    "png 1 bit": (saved(Image.fromarray(BITS).convert("1"), "PNG"), np.repeat(BITS[..., None], 3, axis=2)),
    "png 16 rgb": (png(WIDE, 16, 2), COLORS),
    "png 16 rgba": (png(with_opacity(WIDE, OPACITY * np.uint16(257)), 16, 6), CUT),
    "png 16 grey": (png(GREY * np.uint16(257), 16, 0), GREYS),
    "png 16 grey alpha": (png(np.stack([GREY, OPACITY], -1) * np.uint16(257), 16, 4), GREY_CUT),
    "tiff rgb": (tiff(COLORS, photometric="rgb"), COLORS),
    "tiff rgba": (tiff(with_opacity(COLORS, OPACITY), photometric="rgb", extrasamples=["unassalpha"]), CUT),
    "tiff grey": (tiff(GREY, photometric="minisblack"), GREYS),
    "tiff white is zero": (tiff(255 - GREY, photometric="miniswhite"), GREYS),
    "tiff planes": (tiff(COLORS.transpose(2, 0, 1), photometric="rgb", planarconfig="separate"), COLORS),
    "tiff 16 rgb": (tiff(WIDE, photometric="rgb"), COLORS),
    "tiff 16 big-endian": (tiff(WIDE, photometric="rgb", byteorder=">"), COLORS),
    "tiff 16 deflated": (tiff(WIDE, photometric="rgb", compression="zlib", predictor=True), COLORS),
    "tiff 16 grey": (tiff(GREY * np.uint16(257), photometric="minisblack"), GREYS),
    "tiff 16 rgba": (
        tiff(with_opacity(WIDE, OPACITY * np.uint16(257)), photometric="rgb", extrasamples=["unassalpha"]),
        CUT,
    ),
    "tiff cmyk": (saved(Image.fromarray(INKS, "CMYK"), "TIFF"), COLORS),
    "tiff pages": (saved(RGB, "TIFF", save_all=True, append_images=[Image.new("RGB", (2, 2))]), COLORS),
    "webp": (saved(RGB, "WEBP", lossless=True), COLORS),
    "webp rgba": (saved(RGBA, "WEBP", lossless=True, exact=True), CUT),
    "webp animated": (
        saved(RGB, "WEBP", lossless=True, save_all=True, append_images=[Image.new("RGB", (2, 2))]),
        COLORS,
    ),
    "png animated": (saved(RGB, "PNG", save_all=True, append_images=[Image.new("RGB", (2, 2))]), COLORS),
    "bmp": (saved(RGB, "BMP"), COLORS),
    "bmp palette": (saved(Image.fromarray(GREY), "BMP"), GREYS),
}


@pytest.mark.parametrize("form", READ)
def test_a_form_that_is_read_has_the_right_values(form, tmp_path):
    content, expected = READ[form]
    (tmp_path / "image").write_bytes(content)
    assert np.array_equal(read_image(tmp_path / "image", background=BACKGROUND), expected)


def smooth(mode):
    """A picture that JPEG hardly changes, and its RGB values."""
    image = Image.new("RGB", (32, 32), (200, 120, 40))
    return image.convert(mode), np.array(image)


@pytest.mark.parametrize("mode", ["RGB", "YCbCr", "CMYK"])
def test_jpeg_forms(mode, tmp_path):
    """Pillow writes CMYK as Adobe does, inverted, and YCbCr as every camera does."""
    image, expected = smooth(mode)
    image.save(tmp_path / "image.jpg", quality=100)
    assert np.abs(read_image(tmp_path / "image.jpg").astype(int) - expected).max() <= 2
    assert read_header(tmp_path / "image.jpg").plain == (mode != "CMYK")


@pytest.mark.parametrize("peak", [1023, 4080, 16383])
def test_fewer_bits_in_sixteen_are_refused_because_they_would_be_dark(peak, tmp_path):
    (tmp_path / "image.png").write_bytes(png((WIDE // 65535.0 * peak).astype(np.uint16), 16, 2))
    (tmp_path / "image.tif").write_bytes(tiff((WIDE / 65535.0 * peak).astype(np.uint16), photometric="rgb"))
    for name in ("image.png", "image.tif"):
        with pytest.raises(UserError, match=f"no value above {peak} of 65535.*convert it to 8 bits per channel, with"):
            open_rgb(tmp_path / name)


def test_a_black_image_of_sixteen_bits_is_black(tmp_path):
    (tmp_path / "image.png").write_bytes(png(WIDE * 0, 16, 2))
    assert not read_image(tmp_path / "image.png").any()


REFUSED = {
    "real": tiff(np.zeros((2, 2), np.float32)),
    "real colours": tiff(np.zeros((2, 2, 3), np.float32), photometric="rgb"),
    "double": tiff(np.zeros((2, 2))),
    "signed 16": tiff(np.zeros((2, 2), np.int16)),
    "signed 8": tiff(np.zeros((2, 2), np.int8)),
    "32 bits": tiff(np.zeros((2, 2), np.uint32)),
    "16 bits, planes": tiff(WIDE.transpose(2, 0, 1), photometric="rgb", planarconfig="separate"),
    "16 bits, white is zero": tiff(WIDE[..., 0], photometric="miniswhite"),
    "16 bits, grey and alpha": tiff(WIDE[..., :2], photometric="minisblack", extrasamples=["unassalpha"]),
    "16 bits, inks": tiff(with_opacity(WIDE, WIDE[..., 0]), photometric="separated"),
    "16 bits, transparent colour": png(WIDE, 16, 2, chunk(b"tRNS", struct.pack(">HHH", 1, 2, 3))),
    "lab": saved(RGB.convert("LAB"), "TIFF"),
    "no image": b"photograph",
    "empty": b"",
    "cut": saved(Image.effect_noise((50, 50), 80), "PNG")[:900],
}


@pytest.mark.parametrize("form", REFUSED)
def test_a_form_whose_scale_is_unknown_is_one_line(form, tmp_path):
    (tmp_path / "image").write_bytes(REFUSED[form])
    with pytest.raises(UserError) as caught:
        open_rgb(tmp_path / "image")
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'image'}: the image ")
    assert "8 bits per channel" in line
    assert "\n" not in line


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("form", ["PNG", "JPEG", "TIFF"])
def test_pixels_are_read_as_stored_and_turned_when_asked(orientation, form, tmp_path):
    stored = np.zeros((16, 32, 3), np.uint8)
    stored[:8, :16] = 255
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(stored).save(tmp_path / "image", form, exif=exif)
    header = read_header(tmp_path / "image")
    assert (header.size, header.orientation, header.odd) == ((32, 16), orientation, False)
    assert (read_image(tmp_path / "image") > 128).tolist() == (stored > 128).tolist()
    upright = read_image(tmp_path / "image", orientation)
    corner = {1: (0, 0), 2: (0, 1), 3: (1, 1), 4: (1, 0), 5: (0, 0), 6: (0, 1), 7: (1, 1), 8: (1, 0)}[orientation]
    height, width = (16, 32) if orientation < 5 else (32, 16)
    assert upright.shape == (height, width, 3)
    assert upright[corner[0] * (height - 1), corner[1] * (width - 1), 0] > 128


def exif_block(kind, value):
    """EXIF with an orientation of any type, as no sound program writes it."""
    return b"Exif\0\0II*\0" + struct.pack("<IHHHI4sI", 8, 1, 0x0112, kind, 1, value, 0)


ASCII, SHORT, UNDEFINED = 2, 3, 7


@pytest.mark.parametrize("form", ["PNG", "JPEG", "WEBP"])
@pytest.mark.parametrize(
    "exif",
    [
        exif_block(SHORT, struct.pack("<HH", 0, 0)),
        exif_block(SHORT, struct.pack("<HH", 700, 0)),
        exif_block(ASCII, b"6\0\0\0"),
        exif_block(UNDEFINED, b"\6\0\0\0"),
    ],
)
def test_an_orientation_that_makes_no_sense_counts_as_none(exif, form, tmp_path):
    image = Image.new("RGB", (32, 16), (200, 120, 40))
    image.save(tmp_path / "image", form, exif=exif, quality=95)
    header = read_header(tmp_path / "image")
    assert (header.size, header.orientation, header.odd) == ((32, 16), 1, True)
    assert read_image(tmp_path / "image").shape == (16, 32, 3)


def test_an_image_beyond_pillows_limit_is_read_and_one_beyond_memory_refused(tmp_path):
    Image.new("1", (14_000, 13_000), 1).save(tmp_path / "large.png")
    assert read_header(tmp_path / "large.png").size == (14_000, 13_000)
    (tmp_path / "huge.png").write_bytes(
        png(COLORS, 8, 2).replace(struct.pack(">II", 2, 2), struct.pack(">II", 30_000, 30_000))
    )
    with pytest.raises(UserError, match=r"damaged|30000 x 30000 pixels, more than 400 million; put a smaller copy"):
        open_rgb(tmp_path / "huge.png")


def test_a_tall_image_is_composited_to_its_end(tmp_path):
    """It is done in bands of rows."""
    rng = np.random.default_rng(0)
    colors = rng.integers(0, 256, (700, 3, 4), dtype=np.uint8)
    Image.fromarray(colors).save(tmp_path / "image.png")
    share = colors[..., 3:] / 255.0
    expected = colors[..., :3] * share + np.array([51, 102, 153]) * (1 - share)
    assert np.abs(read_image(tmp_path / "image.png", background=BACKGROUND) - expected).max() <= 0.51


def test_frames_transparency_and_profiles_are_told(tmp_path):
    for form, (content, _) in READ.items():
        (tmp_path / "image").write_bytes(content)
        header = read_header(tmp_path / "image")
        assert header.frames == (form in ("tiff pages", "webp animated", "png animated"))
        assert header.deep == (" 16 " in form)
        assert header.transparent == any(word in form for word in ("rgba", "alpha", "transparen"))
        assert is_translucent(tmp_path / "image") == header.transparent
        if "png" in form:
            assert header.plain == (form in ("png rgb", "png grey"))
    RGB.save(tmp_path / "wide.png", icc_profile=b"Adobe RGB (1998)")
    assert read_header(tmp_path / "wide.png").profile


@pytest.mark.parametrize(("gamma", "other"), [(100_000, True), (45_455, False), (55_556, True)])
def test_linear_values_and_other_gammas_of_png_are_told(gamma, other, tmp_path):
    (tmp_path / "image.png").write_bytes(png(COLORS, 8, 2, chunk(b"gAMA", struct.pack(">I", gamma))))
    assert read_header(tmp_path / "image.png").profile == other
    (tmp_path / "image.png").write_bytes(
        png(COLORS, 8, 2, chunk(b"sRGB", b"\0"), chunk(b"gAMA", struct.pack(">I", gamma)))
    )
    assert not read_header(tmp_path / "image.png").profile
